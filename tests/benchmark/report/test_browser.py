"""The report in a browser without a window: no complaints, all drawn, zoom, phone, dark, print."""

from __future__ import annotations

import base64
import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from benchmark.report.content import content
from benchmark.report.report import write_content
from tests.benchmark.report import synthetic

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
DRIVER = shutil.which("chromedriver")

pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="no chromium with chromedriver is installed"
)

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1200,900",
)


DOUBLE_CLICKS = 10
"""Tries: on a busy machine the second click may come too late, and then they are two."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    webdriver = pytest.importorskip("selenium.webdriver")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('browser')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield driver
    driver.quit()


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


def drawn_plots(browser: Any, paper: str = "light") -> list[Any]:
    """Scroll to every figure and wait until it says that it is drawn for such paper."""
    plots: list[Any] = browser.find_elements("css selector", ".plot")
    for plot in plots:
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
        wait(browser, "arguments[0].dataset.drawn === arguments[1]", plot, paper)
    return plots


def line_colours(browser: Any, plot: Any) -> list[str]:
    found: list[str] = browser.execute_script(
        "return [...arguments[0].querySelectorAll('.js-line')].map(p => p.style.stroke)", plot
    )
    return found


def test_matrix_stands_with_its_cells(page: Any) -> None:
    tables = page.find_elements("css selector", ".matrix table")
    assert len(tables) == 6  # five quantities, and what believing that it cannot spin costs
    rows = tables[0].find_elements("css selector", "tbody tr")
    assert [len(row.find_elements("css selector", "td")) for row in rows] == [3] * 8
    assert any("not observable" in table.text for table in tables)
    assert len(tables[0].find_elements("css selector", "td.best")) == 1


def test_figures_wait_until_they_are_near_and_are_all_drawn(page: Any) -> None:
    last = page.find_elements("css selector", ".plot")[-1]
    assert last.get_attribute("data-drawn") is None
    plots = drawn_plots(page)
    assert len(plots) == 4
    for plot in plots:
        assert plot.get_attribute("data-drawn") == "light"
        assert page.execute_script(
            "return arguments[0].querySelectorAll('.js-line, .point').length", plot
        )


def test_drag_zooms_and_double_click_resets(page: Any) -> None:
    from selenium.common.exceptions import TimeoutException
    from selenium.webdriver.common.action_chains import ActionChains

    plot = drawn_plots(page)[0]
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    layer = plot.find_element("css selector", ".nsewdrag")
    ranges = "arguments[0]._fullLayout.xaxis.range.slice()"
    before = page.execute_script(f"return {ranges}", plot)
    ActionChains(page, duration=50).move_to_element(layer).click_and_hold().move_by_offset(
        150, 0
    ).release().perform()
    changed = f"String({ranges}) !== String(arguments[1])"
    assert wait(page, changed, plot, before)
    low, high = page.execute_script(f"return {ranges}", plot)
    assert before[0] < low < high < before[1]
    second = page.execute_script("return arguments[0]._fullLayout.xaxis2.range", plot)
    assert second == [low, high]
    reset = f"String({ranges}) === String(arguments[1])"
    for _ in range(DOUBLE_CLICKS):
        ActionChains(page, duration=50).move_to_element(layer).double_click().perform()
        with contextlib.suppress(TimeoutException):
            wait(page, reset, plot, before, within_s=2.0)
            break
    assert page.execute_script(f"return {reset}", plot, before)


def test_legend_hides_a_line(page: Any) -> None:
    plot = drawn_plots(page)[0]
    lines = len(line_colours(page, plot))
    button = page.find_element("css selector", ".legend button")
    page.execute_script("arguments[0].click()", button)
    assert button.get_attribute("aria-pressed") == "false"
    assert len(line_colours(page, plot)) < lines


def test_labels_are_text_and_nothing_is_uploaded(page: Any) -> None:
    plot = drawn_plots(page)[-1]
    assert not page.find_elements("css selector", "main img, main b, svg a, a[href^=http]")
    text = page.execute_script("return document.querySelector('main').textContent")
    in_plot = page.execute_script("return arguments[0].textContent", plot)
    for label in synthetic.NASTY:
        assert label in text
        assert label in in_plot
    buttons = page.execute_script(
        "return [...arguments[0].querySelectorAll('.modebar-btn')].map(b => b.dataset.title)", plot
    )
    assert len(buttons) == 4
    # An alert would have stopped the script above; and nothing came over a network.
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_phone_scrolls_only_downwards(page: Any, scheme: str) -> None:
    emulate(page, scheme)
    size = {"width": 360, "height": 740, "deviceScaleFactor": 1, "mobile": True}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page.refresh()
        drawn_plots(page, scheme)
        assert page.execute_script("return innerWidth") == 360
        assert page.execute_script("return document.documentElement.scrollWidth") <= 360
        contents = page.find_element("css selector", "nav.bar details")
        page.execute_script("document.querySelector('nav.bar summary').click()")
        assert contents.get_attribute("open") is not None
        page.execute_script("document.querySelector('nav.bar a').click()")
        assert contents.get_attribute("open") is None
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_dark_paper_changes_the_colours_of_plots(page: Any) -> None:
    plot = drawn_plots(page)[0]
    light = line_colours(page, plot)
    paper = "getComputedStyle(document.body).backgroundColor"
    light_paper = page.execute_script(f"return {paper}")
    emulate(page, "dark")
    plot = drawn_plots(page, "dark")[0]
    assert page.execute_script(f"return {paper}") != light_paper
    dark = line_colours(page, plot)
    assert len(dark) == len(light) > 0
    assert not set(light) & set(dark)


def test_print_holds_everything_in_light_colours(page: Any) -> None:
    emulate(page, "dark")
    drawn_plots(page, "dark")
    page.execute_script(
        "window.seen = {};"
        "addEventListener('beforeprint', () => {"
        "  const plots = [...document.querySelectorAll('.plot')];"
        "  seen.drawn = plots.filter(p => p.dataset.drawn === 'light').length;"
        "  seen.colour = plots[0].querySelector('.js-line').style.stroke;"
        "  seen.closed = document.querySelectorAll('main details:not([open])').length; });"
    )
    pdf = base64.b64decode(page.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF")
    assert len(pdf) > 50_000
    seen = page.execute_script("return window.seen")
    assert seen["drawn"] == 4
    assert seen["closed"] == 0
    assert seen["colour"] not in line_colours(page, drawn_plots(page, "dark")[0])
    assert page.find_elements("css selector", "main details:not([open])")


def test_without_an_observer_all_is_drawn_at_once(browser: Any, address: str) -> None:
    added = browser.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument", {"source": "delete window.IntersectionObserver"}
    )
    browser.get(address)
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)
    assert len(browser.find_elements("css selector", ".plot[data-drawn]")) == 4
    assert browser.get_log("browser") == []
