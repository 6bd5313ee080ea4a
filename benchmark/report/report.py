"""Writes the report of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmark.report.content import Content, content
from benchmark.report.page import page
from benchmark.report.terminal import terminal
from benchmark.tasks.results import Results
from benchmark.tasks.suite import Suite

PAGE, TEXT = "report.html", "report.md"


def write_report(
    results: Results, suites: Sequence[Suite], run: Mapping[str, Any], folder: Path
) -> Path:
    """Write ``report.html`` and ``report.md``; return the path of the former.

    Parameters
    ----------
    results : tables of the run
    suites : that the report shows, in this order
    run : content of ``run.json``; what it lacks is left out
    folder : exists

    Raises
    ------
    InputError
        If a suite's claims cannot be read.
    """
    return write_content(content(results, suites, run), folder)


def write_content(found: Content, folder: Path) -> Path:
    """Write ``report.html`` and ``report.md`` of what was gathered; return the former's path."""
    (folder / TEXT).write_text(terminal(found), "utf-8")
    written = folder / PAGE
    written.write_text(page(found), "utf-8")
    return written
