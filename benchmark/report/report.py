"""Writes the report of a run."""

from __future__ import annotations

from pathlib import Path

from benchmark.report.content import Content
from benchmark.report.page import page
from benchmark.report.terminal import terminal

PAGE, TEXT = "report.html", "report.md"


def write_content(found: Content, folder: Path) -> Path:
    """Write ``report.html`` and ``report.md`` of what was gathered; return the former's path."""
    (folder / TEXT).write_text(terminal(found), "utf-8")
    written = folder / PAGE
    written.write_text(page(found), "utf-8")
    return written
