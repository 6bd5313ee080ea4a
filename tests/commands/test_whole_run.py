"""The whole benchmark with one seed, as ``make benchmark`` runs it: its report stays small."""

from __future__ import annotations

import os
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest

from suites.table import MODULES, find_suite

MOST_BYTES = 3_000_000


@pytest.mark.slow
def test_the_report_of_a_whole_run_is_small(tmp_path: Path) -> None:
    """Seeds add little: a figure draws some of them, however many there are."""
    command = ("-m", "commands.cli", "benchmark", "--seeds", "1", "--jobs", "2", "--output", ".")
    house = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(house)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "report.html").read_text("utf-8")
    for name in set(MODULES) - {"real"}:  # needs recordings
        assert find_suite(name).title in unescape(page), name
    assert len(page.encode()) < MOST_BYTES
