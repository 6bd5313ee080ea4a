"""Writes the report of a run."""

from __future__ import annotations

from pathlib import Path

from benchmark.report.content import Content
from benchmark.report.page import page
from benchmark.report.terminal import terminal
from estimation.output_file import write_whole_files

PAGE, TEXT = "report.html", "report.md"


def write_content(found: Content, folder: Path) -> Path:
    """Write ``report.html`` and ``report.md`` of what was gathered; return the former's path."""
    write_whole_files(folder, {TEXT: terminal(found), PAGE: page(found)})
    return folder / PAGE
