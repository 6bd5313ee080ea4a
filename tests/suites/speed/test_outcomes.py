"""From rows of a race to outcomes, and from results to figures and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.runner.tables import result_rows
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.task import OK, Task
from suites.shared_core import SHARED_CORE
from suites.speed.cases import CASES
from suites.speed.clock import OWN_WALL_CLOCK
from suites.speed.contender import (
    CONVERGED,
    FULL_STREAM_CALL,
    ONE_PASS,
    PASS_CALL,
    STREAM_CALL,
    Entry,
)
from suites.speed.figures import figures
from suites.speed.outcomes import LEFT_OUT, outcomes
from suites.speed.rows import Row
from suites.speed.tables import HEAD, tables

ROW = Row(
    problem="pen15",
    bounds=False,
    contender="mhe-rti",
    mode=ONE_PASS,
    horizon=20,
    windows=3,
    median_s=1e-3,
    p99_s=2e-3,
    max_s=3e-3,
    cost=4.0,
    build_s=5.0,
    version="pen-mhe 1",
    newest_error_std=0.5,
    newest_error_max_std=0.75,
    solved=1.0,
    min_s=0.9e-3,
    cpu_min_s=0.8e-3,
    cpu_median_s=0.85e-3,
)
CALL = replace(ROW, mode=PASS_CALL, median_s=1e-4, clock=OWN_WALL_CLOCK)


def entry(name: str, mode: str) -> Entry[Any]:
    return Entry(name, mode, lambda model, item: None)  # type: ignore[arg-type, return-value]


def results_of(rows: Sequence[Row], case: str) -> Results:
    found = outcomes("a model", [*dict.fromkeys(row.contender for row in rows)], rows, {})
    told = [
        row
        for name, outcome in found.items()
        for row in result_rows(Task("speed", case, CASES[case].sensors, name, 0), outcome)
    ]
    return Results(
        pd.DataFrame(told, columns=list(RESULT_COLUMNS)),
        pd.DataFrame(columns=list(SERIES_COLUMNS)),
    )


def joined(*parts: Results) -> Results:
    return Results(pd.concat([part.rows for part in parts]), parts[0].series)


def test_every_figure_of_a_row_is_a_quantity() -> None:
    bounded = replace(ROW, bounds=True, active_rows=2.5, violation_std=0.1)
    found = outcomes("a model", ["mhe-rti"], [bounded, replace(CALL, bounds=True)], {})["mhe-rti"]
    assert (found.model, found.samples, found.solved_fraction, found.status) == (
        "a model",
        3,
        1,
        OK,
    )
    assert (found.step_time_median_s, found.step_time_p99_s) == (1e-3, 2e-3)
    assert found.reason == f"pen-mhe 1; {PASS_CALL}: CPU time by {OWN_WALL_CLOCK}"
    figure = {quantity.name: (quantity.bias, quantity.unit) for quantity in found.quantities}
    of_pass = {name: value for name, value in figure.items() if name.startswith("one pass: ")}
    assert of_pass == {
        "one pass: least CPU time": (pytest.approx(800), "µs"),
        "one pass: median CPU time": (pytest.approx(850), "µs"),
        "one pass: least time": (pytest.approx(900), "µs"),
        "one pass: median time": (pytest.approx(1000), "µs"),
        "one pass: 99 % time": (pytest.approx(2000), "µs"),
        "one pass: longest time": (pytest.approx(3000), "µs"),
        "one pass: cost": (4.0, "1"),
        "one pass: newest state": (0.5, "σ"),
        "one pass: newest state at worst": (0.75, "σ"),
        "one pass: excess over bounds": (0.1, "σ"),
        "one pass: solved": (1.0, "1"),
        "one pass: time to build": (5.0, "s"),
    }
    assert figure["one pass, compiled call: median time"][0] == pytest.approx(100)
    assert figure["active rows"] == (2.5, "1")
    assert figure["cores"] == (1.0, "cores")


def test_what_a_row_has_not_is_no_quantity() -> None:
    bare = replace(ROW, cost=None, newest_error_std=None, newest_error_max_std=None)
    found = outcomes("a model", ["mhe-rti"], [bare], {})["mhe-rti"]
    names = {quantity.name for quantity in found.quantities}
    assert not names & {"one pass: cost", "one pass: newest state", "active rows"}


def test_who_is_left_out_has_a_status_and_a_reason() -> None:
    left_out = {
        entry("osqp", ONE_PASS): "osqp cannot be imported",
        entry("osqp", PASS_CALL): "osqp cannot be imported",
        entry("mhe-rti", PASS_CALL): "there is no compiler",
    }
    found = outcomes("a model", ["mhe-rti", "osqp"], [ROW], left_out)
    absent = found["osqp"]
    assert (absent.status, absent.reason) == (LEFT_OUT, "osqp cannot be imported")
    assert absent.quantities == ()
    assert found["mhe-rti"].status == OK
    assert found["mhe-rti"].reason == f"pen-mhe 1; {PASS_CALL}: left out, there is no compiler"


@pytest.mark.parametrize(
    ("share", "status", "says"),
    [(0.95, OK, ""), (0.9499, SHARED_CORE, "only 94 % of a core; "), (0.5, SHARED_CORE, "only 50")],
)
def test_a_shared_core_has_a_status(share: float, status: str, says: str) -> None:
    """Which no claim counts: a run on a loaded machine said 422 times, met."""
    rows = [replace(ROW, core_share=1.0), replace(CALL, core_share=share)]
    found = outcomes("a model", ["mhe-rti"], rows, {})["mhe-rti"]
    assert found.status == status
    assert found.reason.startswith(f"{says}" if says else "pen-mhe 1")


def test_a_mode_with_several_horizons_says_which() -> None:
    rows = [
        replace(ROW, mode=mode, horizon=N)
        for N in (20, 100)
        for mode in (STREAM_CALL, FULL_STREAM_CALL)
    ]
    found = outcomes("a model", ["mhe-rti"], rows, {})["mhe-rti"]
    modes = dict.fromkeys(q.name.rpartition(": ")[0] for q in found.quantities if ":" in q.name)
    assert list(modes) == [
        f"{mode}, N = {N}" for N in (20, 100) for mode in (STREAM_CALL, FULL_STREAM_CALL)
    ]


def test_figures_join_a_compiled_call_with_all_of_it() -> None:
    slow = replace(ROW, contender="ipopt", mode=CONVERGED, median_s=8e-3, newest_error_std=1e-9)
    long = [replace(ROW, horizon=100, median_s=5e-3), replace(slow, horizon=100, median_s=40e-3)]
    found = joined(results_of([ROW, CALL, slow], "pen15_20"), results_of(long, "pen15_100"))
    quality, horizons = figures(found)
    assert [panel.title for panel in quality.panels] == ["pen15, N = 20", "pen15, N = 100"]
    lines = {line.name: line for line in quality.panels[0].lines}
    np.testing.assert_allclose(lines["mhe-rti"].x, [0.1, 1])
    np.testing.assert_allclose(lines["mhe-rti"].y, [0.5, 0.5])
    np.testing.assert_allclose(lines["ipopt"].y, [1e-9])
    (panel,) = horizons.panels
    assert {line.name: line.x.tolist() for line in panel.lines} == {
        "mhe-rti": [20, 100],
        "ipopt": [20, 100],
    }
    assert horizons.caption.endswith("pen15: mhe-rti 1.00, ipopt 1.00.")


def test_figures_say_where_the_core_was_shared() -> None:
    slow = results_of([replace(ROW, core_share=0.5)], "pen24_20")
    for figure in figures(joined(results_of([ROW], "pen15_20"), slow)):
        assert ("Other work ran beside pen24_20: " in figure.caption) == (figure.key == "speed")
    assert not any("Other work" in f.caption for f in figures(results_of([ROW], "pen15_20")))


def test_without_rows_there_are_no_figures_and_no_tables() -> None:
    empty = results_of([], "pen15_20")
    assert figures(empty) == tables(empty) == []


def test_windows_and_streams_have_tables_of_their_own() -> None:
    stream = [replace(ROW, mode=STREAM_CALL, horizon=N, cost=None) for N in (20, 100)]
    found = joined(results_of([ROW, CALL], "pen15_20"), results_of(stream, "pen24_stream"))
    windows, streams = tables(found)
    assert [row[:4] for row in windows[3]] == [
        ("pen15_20", "mhe-rti", ONE_PASS, "800 µs"),
        ("pen15_20", "mhe-rti", PASS_CALL, "800 µs"),
    ]
    assert [row[2] for row in streams[3]] == [f"{STREAM_CALL}, N = {N}" for N in (20, 100)]
    assert all(len(row) == len(HEAD) for table in (windows, streams) for row in table[3])
