"""Every notebook runs from top to bottom, asks a question and answers it."""

from __future__ import annotations

import json
import re
import resource
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="the extra [notebooks] is not installed")
pytest.importorskip("nbclient", reason="the extra [notebooks] is not installed")

from tests.executed_notebooks import NOTEBOOKS, executed  # noqa: E402

QUICK = ("first_light",)
MOST_CPU_S = 60.0
"""CPU time: other tests run beside."""


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_opens_with_a_question_and_ends_with_an_answer(path: Path) -> None:
    cells = json.loads(path.read_text("utf-8"))["cells"]
    first, last = ("".join(cells[i]["source"]) for i in (0, -1))
    assert [cells[i]["cell_type"] for i in (0, -1)] == ["markdown", "markdown"]
    assert re.match(r"# [^\n]+\n\n\*\*[^\n]+\?\*\*", first)
    assert "## Answer\n\n" in last
    assert any(cell.get("outputs") for cell in cells), "keep the figures in the file"
    assert not any(
        output["output_type"] == "error" for cell in cells for output in cell.get("outputs", [])
    )


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=() if path.stem in QUICK else pytest.mark.slow)
        for path in NOTEBOOKS
    ],
)
def test_notebook_runs(path: Path) -> None:
    nbformat.validate(nbformat.read(path, as_version=4))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    executed(path)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert 0 < cpu_s < MOST_CPU_S
