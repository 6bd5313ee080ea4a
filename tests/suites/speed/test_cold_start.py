"""The stopwatch of cold starts: fresh processes, a cache of their own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from suites.speed import cold_start
from suites.speed.cold_start import ColdStart

EXPECTED_FIGURES = [f"import {module}" for module in cold_start.IMPORTS] + [
    "first estimate of ekf, compiled before",
    "building ekf with 15 states, compilation",
]


def test_the_median_is_the_middle() -> None:
    assert ColdStart("import", (9.0, 1.0, 2.0)).median_s == 2.0


def test_a_fresh_process_has_imported_nothing_yet() -> None:
    """In this process the module is there already: only looked up."""
    module = "mhe.reference.ipopt"
    cold_start.import_s(module)
    assert cold_start._fresh(f"import_s({module!r})") > 100 * cold_start.import_s(module)


@pytest.mark.skipif(not shutil.which("gcc"), reason="no compiler, nothing to compile")
def test_a_build_compiles_into_the_cache_that_it_is_given(tmp_path: Path) -> None:
    cold = cold_start._fresh("build_s('ekf')", str(tmp_path))
    libraries = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.so")}
    assert libraries
    warm = cold_start._fresh("build_s('ekf')", str(tmp_path))
    assert warm < cold
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.so")} == libraries


def test_every_figure_is_timed_as_often_as_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes replaced by a clock that counts; the warm cache costs one more process."""
    calls: list[tuple[str, str | None]] = []

    def fresh(call: str, cache: str | None = None) -> float:
        calls.append((call, cache))
        return float(len(calls))

    monkeypatch.setattr(cold_start, "_fresh", fresh)
    figures = cold_start.cold_start(runs=3, estimators=["ekf"])
    assert [figure.what for figure in figures] == EXPECTED_FIGURES
    assert all(len(figure.seconds) == 3 for figure in figures)
    assert len(calls) == 3 * len(figures) + 1
    warm = [cache for call, cache in calls if call.startswith("first_estimate_s")]
    cold = [cache for call, cache in calls if call.startswith("build_s")]
    assert len(set(warm)) == 1
    assert None not in warm
    assert len(set(cold)) == len(cold) == 3
