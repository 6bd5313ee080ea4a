"""What tests of the page ask a browser without a window."""

from __future__ import annotations

from typing import Any

RANGES = "arguments[0].view.panels.map(p => p.range[0].slice())"
"""Of the x axes of a plot's panels."""


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
