"""The page of a report that tests make up, in a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from benchmark.report.content import content
from benchmark.report.report import write_content
from tests.benchmark.report import synthetic
from tests.benchmark.report.page_in_browser import emulate
from tests.browser import started


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    yield from started(tmp_path_factory.mktemp("browser"))


@pytest.fixture(scope="session")
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
