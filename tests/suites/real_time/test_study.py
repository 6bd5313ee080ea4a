"""``pen-mhe real-time`` writes what it prints."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from suites.real_time.streams import CASES
from suites.real_time.study import run_real_time


def test_without_recordings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run_real_time(tmp_path / "new", None, 50, horizons=(4,), thresholds=(0.5, math.inf))
    said = capsys.readouterr().out
    assert "left out" in said
    assert "(default)" in said
    parts = json.loads((tmp_path / "new" / "real_time.json").read_text())
    assert parts["times"] == []
    assert {row["case"] for row in parts["reuse"]} == {
        name for name, case in CASES.items() if not case.is_real
    }
    assert all(0 <= row["in_time"] <= 1 for row in parts["deadlines"])
    assert (tmp_path / "new" / "real_time_reuse.png").stat().st_size > 10_000
