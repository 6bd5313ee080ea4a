"""The page about constraints runs, and says what happens."""

from __future__ import annotations

from pathlib import Path

from tests.pages import run_python

PAGE = Path(__file__).resolve().parents[2] / "docs" / "constraints.md"


def test_the_page_runs() -> None:
    names = run_python(PAGE)
    for history in ("free", "walled", "buffered", "braked", "history"):
        assert all(status.is_solved for status in names[history].status)
