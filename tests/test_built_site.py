"""The site as `make docs` builds it: strictly, from here alone, and fit for a phone."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pen_mhe as pm
from tests.browser import CHROMIUM, DRIVER, started
from tests.pages import PAGES, ROOT

WIDTHS = (360, 390, 1300)
"""Of phones, and of a desk."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` does."""
    pytest.importorskip("sphinx", reason="the extra [docs] is not installed")
    pytest.importorskip("furo", reason="the extra [docs] is not installed")
    rule = re.search(
        r"-m sphinx (.+?)\. build/docs$",
        (ROOT / "Makefile").read_text("utf-8"),
        re.MULTILINE | re.DOTALL,
    )
    assert rule
    folder = tmp_path_factory.mktemp("site")
    words = rule[1].replace("\\\n", " ").replace("build/doctrees", str(folder / "trees")).split()
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words, ".", str(folder / "site")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert not done.stderr
    return folder / "site"


def test_the_site_comes_from_here_alone(built: Path) -> None:
    """No font, script, style or picture from another machine: links go there, nothing else."""
    pages = list(built.rglob("*.html"))
    assert len(pages) > len(PAGES)
    for page in pages:
        text = page.read_text("utf-8")
        assert not re.search(r"<(?:script|img|iframe|source)[^>]*src=\"(?:https?:)?//", text), page
        for tag in re.findall(r"<link [^>]*>", text):
            assert not re.search(r"href=\"(?:https?:)?//", tag), f"{page}: {tag}"
    for style in built.rglob("*.css"):
        assert not re.search(r"url\(['\"]?https?:|@import", style.read_text("utf-8")), style


def test_the_site_begins_and_its_suites_are_told(built: Path) -> None:
    assert 'url=docs/index.html"' in (built / "index.html").read_text("utf-8")
    pen = (built / "docs" / "suites" / "pen.html").read_text("utf-8")
    assert "pen-1-accurate" in pen
    assert "free pen, handwriting" in pen
    api = (built / "docs" / "api.html").read_text("utf-8")
    assert all(f'id="pen_mhe.{name}"' in api for name in pm.__all__)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    if not (CHROMIUM and DRIVER):
        pytest.skip("no chromium with chromedriver is installed")
    yield from started(tmp_path_factory.mktemp("browser"))


@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_is_wider_than_its_window_or_complains(
    built: Path, browser: Any, width: int
) -> None:
    window = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", window)
    browser.get_log("browser")
    for page in sorted((built / "docs").rglob("*.html")) + sorted(built.glob("notebooks/*.html")):
        browser.get(page.as_uri())
        wide = browser.execute_script("return document.documentElement.scrollWidth")
        assert wide <= width, f"{page.name} is {wide} pixels wide in a window of {width}"
        assert browser.get_log("browser") == [], page.name


def test_search_finds_pages_in_a_folder_without_a_server(built: Path, browser: Any) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(f"{(built / 'search.html').as_uri()}?q=turntable")
    found = WebDriverWait(browser, 20).until(
        lambda driver: driver.find_elements(By.CSS_SELECTOR, "#search-results li a")
    )
    assert any("turntable" in (link.get_attribute("href") or "") for link in found)
    assert browser.get_log("browser") == []


def test_it_is_dark_where_the_reader_is(built: Path, browser: Any) -> None:
    lightness = {}
    for scheme in ("light", "dark"):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": features})
        browser.get((built / "docs" / "index.html").as_uri())
        colour = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
        lightness[scheme] = sum(map(int, re.findall(r"\d+", colour)[:3]))
    assert lightness["dark"] < 150 < 600 < lightness["light"]
