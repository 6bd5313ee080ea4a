"""The report under a mouse: zoom, values beside the pointer, legend, a picture to keep."""

from __future__ import annotations

import contextlib
from typing import Any
from xml.etree import ElementTree

import pytest

from tests.benchmark.report import synthetic
from tests.benchmark.report.page_in_browser import RANGES, drawn_plots, line_colours, wait
from tests.browser import CHROMIUM, DRIVER

pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="no chromium with chromedriver is installed"
)

DOUBLE_CLICKS = 10
"""Tries: on a busy machine the second click may come too late, and then they are two."""


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
