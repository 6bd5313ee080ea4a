"""The report on a phone: it scrolls only downwards, breaks no word, and a finger zooms and asks."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import pytest

from tests.benchmark.report.page_in_browser import RANGES, drawn_plots, emulate, wait
from tests.browser import CHROMIUM, DRIVER

pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="no chromium with chromedriver is installed"
)


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


@pytest.mark.cover
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
