"""The report in a browser without a window: no complaints, picture, zoom, touch, phone, print."""

from __future__ import annotations

import base64
import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from benchmark.report.content import content
from benchmark.report.report import write_content
from tests.benchmark.report import synthetic
from tests.browser import CHROMIUM, DRIVER, started

pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="no chromium with chromedriver is installed"
)

DOUBLE_CLICKS = 10
"""Tries: on a busy machine the second click may come too late, and then they are two."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    yield from started(tmp_path_factory.mktemp("browser"))


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder: Path = tmp_path_factory.mktemp("page")
    suites = synthetic.suites(folder)
    return write_content(content(synthetic.results(), suites, synthetic.RUN), folder).as_uri()


@pytest.fixture
def page(browser: Any, address: str) -> Iterator[Any]:
    """The page, freshly opened in light colours; what the test does must leave no complaint."""
    emulate(browser, "light")
    browser.get_log("browser")
    browser.get(address)
    yield browser
    assert browser.get_log("browser") == []


def emulate(browser: Any, scheme: str) -> None:
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": [feature]})


def wait(browser: Any, script: str, *arguments: object, within_s: float = 20.0) -> Any:
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(browser, within_s, 0.05).until(
        lambda found: found.execute_script(f"return {script}", *arguments)
    )


def drawn_plots(browser: Any) -> list[Any]:
    """Scroll to every figure and wait until it says that it is drawn."""
    plots: list[Any] = browser.find_elements("css selector", ".plot")
    for plot in plots:
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
        wait(browser, "arguments[0].dataset.drawn === 'yes'", plot)
    return plots


def line_colours(browser: Any, plot: Any) -> list[str]:
    found: list[str] = browser.execute_script(
        "return [...arguments[0].querySelectorAll('.line .marks')]"
        ".map(p => getComputedStyle(p).stroke)",
        plot,
    )
    return found


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


RANGES = "arguments[0].view.panels.map(p => p.range[0].slice())"


def test_drag_zooms_and_double_click_resets(page: Any) -> None:
    from selenium.common.exceptions import TimeoutException
    from selenium.webdriver.common.action_chains import ActionChains

    plot = drawn_plots(page)[0]
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    before = page.execute_script(f"return {RANGES}", plot)
    drag = ActionChains(page, duration=50).move_to_element_with_offset(plot, 0, -80)
    drag.click_and_hold().move_by_offset(150, 0).release().perform()
    changed = f"String({RANGES}) !== String(arguments[1])"
    assert wait(page, changed, plot, before)
    first, second = page.execute_script(f"return {RANGES}", plot)
    assert before[0][0] < first[0] < first[1] < before[0][1]
    assert second == first  # panels of one column
    button = page.find_element("css selector", ".reset")
    assert button.is_displayed()
    reset = f"String({RANGES}) === String(arguments[1])"
    for _ in range(DOUBLE_CLICKS):
        ActionChains(page, duration=50).move_to_element(plot).double_click().perform()
        with contextlib.suppress(TimeoutException):
            wait(page, reset, plot, before, within_s=2.0)
            break
    assert page.execute_script(f"return {reset}", plot, before)
    assert not button.is_displayed()


def test_values_stand_beside_the_pointer(page: Any) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    plot = drawn_plots(page)[0]
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    ActionChains(page, duration=50).move_to_element_with_offset(plot, 60, -80).perform()
    shown = wait(page, "arguments[0].querySelector('.values')?.textContent", plot)
    assert "time" in shown
    for name in ("ekf: ", "mhe: ", "truth: "):
        assert name in shown


def test_a_picture_is_saved_with_its_legend(page: Any) -> None:
    plot = drawn_plots(page)[-1]
    page.execute_script(
        "URL.createObjectURL = (blob) => {"
        "  blob.text().then(t => { window.saved = t; });"
        "  return '#'; };"
        "arguments[0].closest('figure').querySelector('.save').click()",
        plot,
    )
    text = wait(page, "window.saved")
    drawing = ElementTree.fromstring(text)
    assert "var(" not in text
    texts = [node.text for node in drawing.iter("{http://www.w3.org/2000/svg}text")]
    for label in synthetic.NASTY[:2]:
        assert label in texts


def test_legend_hides_a_line(page: Any) -> None:
    plot = drawn_plots(page)[0]
    lines = len(line_colours(page, plot))
    button = page.find_element("css selector", "figure:not(.glance) .legend > button")
    page.execute_script("arguments[0].click()", button)
    assert button.get_attribute("aria-pressed") == "false"
    assert len(line_colours(page, plot)) < lines


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


@contextlib.contextmanager
def phone(browser: Any, width: int) -> Iterator[None]:
    size = {"width": width, "height": 740, "deviceScaleFactor": 1, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    try:
        browser.refresh()
        yield
    finally:
        browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def tap(browser: Any, x: float, y: float) -> None:
    for kind, points in (("touchStart", [{"x": x, "y": y}]), ("touchEnd", [])):
        touch = {"type": kind, "touchPoints": points}
        browser.execute_cdp_cmd("Input.dispatchTouchEvent", touch)


CENTRE = (
    "(b => [b.x + b.width / 2, b.y + b.height / 2])"
    "((arguments[0].scrollIntoView({block: 'center'}), arguments[0]).getBoundingClientRect())"
)


@pytest.mark.parametrize("width", [360, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_phone_scrolls_only_downwards(page: Any, scheme: str, width: int) -> None:
    emulate(page, scheme)
    with phone(page, width):
        drawn_plots(page)
        assert page.execute_script("return innerWidth") == width
        assert page.execute_script("return document.documentElement.scrollWidth") <= width
        contents = page.find_element("css selector", "nav.bar details")
        page.execute_script("document.querySelector('nav.bar summary').click()")
        assert contents.get_attribute("open") is not None
        page.execute_script("document.querySelector('nav.bar a').click()")
        assert contents.get_attribute("open") is None


# Words of cells that stand on two lines: a range has a rectangle per line.
BROKEN_WORDS = """[...document.querySelectorAll('.matrix th, .matrix td, .pane .label')]
  .flatMap(cell => {
    const found = [], walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode;
      for (const word of node.data.matchAll(/[a-z]+/gi)) {
        const range = document.createRange();
        range.setStart(node, word.index);
        range.setEnd(node, word.index + word[0].length);
        const lines = new Set([...range.getClientRects()].map(r => Math.round(r.top)));
        const over = range.getBoundingClientRect().right - cell.getBoundingClientRect().right;
        if (lines.size > 1 || over > 2) found.push(word[0]);
      }
    }
    return found;
  })"""


@pytest.mark.parametrize("width", [360, 390])
def test_a_phone_shows_every_column_and_breaks_no_word(page: Any, width: int) -> None:
    with phone(page, width):
        cells = page.execute_script(
            "return [...document.querySelectorAll('.matrix tr > :last-child')]"
            ".map(c => c.getBoundingClientRect().right)"
        )
        assert cells
        assert max(cells) <= width
        assert page.execute_script(f"return {BROKEN_WORDS}") == []


def test_a_touch_explains_a_term_and_shows_values(page: Any) -> None:
    with phone(page, 390):
        term = page.find_element("css selector", "#answer a.term")
        tap(page, *page.execute_script(f"return {CENTRE}", term))
        shown = wait(page, "document.querySelector('.meaning')?.textContent")
        meaning = page.execute_script(
            "return document.querySelector(arguments[0].hash + ' dd').textContent", term
        )
        assert shown.endswith(meaning)
        box = "document.querySelector('.meaning').getBoundingClientRect()"
        left, right = page.execute_script(f"return [{box}.left, {box}.right]")
        assert left >= 0
        assert right <= 390
        tap(page, 3, 400)  # beside the text
        assert wait(page, "document.querySelector('.meaning') === null")
        plot = drawn_plots(page)[0]
        x, y = page.execute_script(f"return {CENTRE}", plot)
        tap(page, x, y - 80)  # on the upper panel
        assert wait(page, "arguments[0].querySelector('.values')?.textContent", plot)


def test_a_finger_zooms_where_it_is_asked_to(page: Any) -> None:
    with phone(page, 390):
        plot = drawn_plots(page)[0]
        button = page.find_element("css selector", ".zoom")
        assert button.is_displayed()
        page.execute_script("arguments[0].click()", button)
        x, y = page.execute_script(f"return {CENTRE}", plot)
        before = page.execute_script(f"return {RANGES}", plot)
        for kind, at in (("touchStart", -60), ("touchMove", 0), ("touchMove", 60), ("touchEnd", 0)):
            points = [] if kind == "touchEnd" else [{"x": x + at, "y": y - 80}]
            page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        assert wait(page, f"String({RANGES}) !== String(arguments[1])", plot, before)


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
