"""The page about outliers runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.pages import of_language, run_python

PAGE = Path(__file__).resolve().parents[2] / "docs" / "outliers.md"


@pytest.mark.usefixtures("interpreted")
def test_the_page_runs() -> None:
    assert of_language(PAGE, "python")
    run_python(PAGE)
