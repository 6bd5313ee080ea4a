"""The report in a browser without a window: no complaints, matrix, pictures, axes, dark, print."""

from __future__ import annotations

import base64
import json
from typing import Any

import pytest

from tests.benchmark.report import synthetic
from tests.benchmark.report.page_in_browser import drawn_plots, emulate, line_colours
from tests.browser import CHROMIUM, DRIVER

pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="no chromium with chromedriver is installed"
)


def test_matrix_stands_with_its_cells(page: Any) -> None:
    tables = page.find_elements("css selector", ".matrix table")
    assert len(tables) == 6  # five quantities, and what believing that it cannot spin costs
    rows = tables[0].find_elements("css selector", "tbody tr")
    assert [len(row.find_elements("css selector", "td")) for row in rows] == [3] * 8
    assert any("not observable" in table.text for table in tables)
    assert len(tables[0].find_elements("css selector", "td.best")) == 1


def test_the_first_picture_has_every_choice_and_estimator(page: Any) -> None:
    """Without a script: before any table, a mark per figure, and what to take is shaded."""
    panes = page.find_elements("css selector", ".glance .pane")
    assert len(panes) == 5
    first = page.find_element("css selector", "main figure, main table")
    assert "glance" in first.get_attribute("class")
    rows = panes[0].find_elements("css selector", ".row:not(.scale)")
    assert [row.find_element("css selector", ".label").text for row in rows] == list(
        synthetic.ERRORS
    )
    marks = [len(row.find_elements("css selector", ".median-mark")) for row in rows]
    assert max(marks) == 3
    taken = [row for row in rows if "taken" in row.get_attribute("class")]
    assert [row.find_element("css selector", ".budget").text for row in taken] == [
        "without a camera",
        "with a camera",
    ]
    shapes = page.execute_script(
        "return [...document.querySelectorAll('.glance .legend path')]"
        ".map(p => p.getAttribute('d'))"
    )
    assert len(set(shapes)) == 3
    places = page.execute_script(
        "return [...arguments[0].querySelectorAll('.median-mark')]"
        ".map(m => m.getBoundingClientRect().x)",
        panes[0],
    )
    assert len(set(places)) > 6


@pytest.mark.parametrize("width", [390, 1280])
def test_a_long_name_of_sensors_makes_its_row_higher(page: Any, width: int) -> None:
    """In all panels alike where they stand beside each other; it is not over the next row."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    label, row, *others = page.execute_script(
        """
        const row = document.querySelector('.glance .row'), label = row.querySelector('.label');
        const told = label.textContent;
        label.textContent = 'accelerometer and '.repeat(9);
        const boxes = [label, ...document.querySelectorAll('.glance .pane > .row:nth-of-type(1)')]
            .map((e) => e.getBoundingClientRect()).map((b) => [b.top, b.bottom]);
        label.textContent = told;
        return boxes;
        """
    )
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert label[0] >= row[0]
    assert label[1] <= row[1]
    beside = [other for other in others if other[0] == row[0]]
    assert len(beside) == (4 if width == 1280 else 0)
    assert all(other == row for other in beside)


def test_figures_wait_until_they_are_near_and_are_all_drawn(page: Any) -> None:
    last = page.find_elements("css selector", ".plot")[-1]
    assert last.get_attribute("data-drawn") is None
    plots = drawn_plots(page)
    assert len(plots) == 4
    for plot in plots:
        assert plot.get_attribute("data-drawn") == "yes"
        assert page.execute_script(
            "return arguments[0].querySelectorAll('.line path[d^=M]').length", plot
        )


def test_every_axis_has_labels(page: Any) -> None:
    """Logarithmic ones too, also where they do not hold a decade."""
    for plot in drawn_plots(page):
        found = page.execute_script(
            "const view = arguments[0].view;"
            "return view.panels.map(p => [p.yTicks.length, p.numbered ? p.xTicks.length : 9])",
            plot,
        )
        assert found
        assert min(map(min, found)) >= 2
    ticks = (
        "return [[0.62, 0.68], [0.06, 0.3], [3, 40], [1e-3, 1e4]].map(r => Chart.ticks(r, true, 5))"
    )
    assert all(2 < len(found) < 12 for found in page.execute_script(ticks))


def test_a_panel_of_one_value_has_the_axis_of_its_neighbour(page: Any) -> None:
    spec = {
        "columns": 2,
        "panels": [
            {
                "title": "", "x": "x", "y": "share (%)", "logs": [False, False], "equal": False,
                "shares": 0, "labelled": [True, True],
                "lines": [{"name": 0, "style": "line", "x": [0, 1, 2], "y": y}],
            }
            for y in ([0, 20, 40], [0, 0, 0])
        ],
    }  # fmt: skip
    ranges = page.execute_script(
        "return Chart.read(arguments[0]).panels.map(p => p.range[1])", json.dumps(spec)
    )
    assert ranges[0] == ranges[1]
    spec["panels"] = spec["panels"][1:]  # type: ignore[index]
    (alone,) = page.execute_script(
        "return Chart.read(arguments[0]).panels.map(p => p.range[1])", json.dumps(spec)
    )
    assert alone == [0, 1]


def test_labels_are_text_and_nothing_is_uploaded(page: Any) -> None:
    plot = drawn_plots(page)[-1]
    assert not page.find_elements("css selector", "main img, main b, svg a, a[href^=http]")
    text = page.execute_script("return document.querySelector('main').textContent")
    # A label may stand on several lines.
    in_plot = page.execute_script(
        "return [...arguments[0].querySelectorAll('text')].map(t => t.textContent).join(' ')", plot
    )
    for label in synthetic.NASTY:
        assert label in text
        assert label in in_plot
    # An alert would have stopped the script above; and nothing came over a network.
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_every_term_leads_to_its_meaning(page: Any) -> None:
    lost = page.execute_script(
        "return [...document.querySelectorAll('a.term')].map(a => a.hash)"
        ".filter(h => !document.querySelector(h + ' dd')?.textContent)"
    )
    assert lost == []


def test_dark_paper_changes_the_colours_of_plots(page: Any) -> None:
    plot = drawn_plots(page)[0]
    light = line_colours(page, plot)
    paper = "getComputedStyle(document.body).backgroundColor"
    light_paper = page.execute_script(f"return {paper}")
    emulate(page, "dark")
    plot = drawn_plots(page)[0]
    assert page.execute_script(f"return {paper}") != light_paper
    dark = line_colours(page, plot)
    assert len(dark) == len(light) > 0
    assert not set(light) & set(dark)


def test_print_holds_everything_in_light_colours(page: Any) -> None:
    light = line_colours(page, drawn_plots(page)[0])
    emulate(page, "dark")
    page.refresh()
    page.execute_script(
        "window.seen = {};"
        "addEventListener('beforeprint', () => {"
        "  seen.drawn = document.querySelectorAll('.plot svg').length;"
        "  seen.closed = document.querySelectorAll('main details:not([open])').length; });"
    )
    pdf = base64.b64decode(page.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF")
    assert len(pdf) > 50_000
    seen = page.execute_script("return window.seen")
    assert seen == {"drawn": 4, "closed": 0}
    assert page.find_elements("css selector", "main details:not([open])")
    dark = {"name": "prefers-color-scheme", "value": "dark"}
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": [dark]})
    assert line_colours(page, drawn_plots(page)[0]) == light
    paper = "getComputedStyle(document.body).backgroundColor"
    assert page.execute_script(f"return {paper}") == "rgb(255, 255, 255)"


def test_without_an_observer_all_is_drawn_at_once(browser: Any, address: str) -> None:
    added = browser.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument", {"source": "delete window.IntersectionObserver"}
    )
    browser.get(address)
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)
    assert len(browser.find_elements("css selector", ".plot[data-drawn]")) == 4
    assert browser.get_log("browser") == []
