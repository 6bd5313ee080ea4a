"""`mhe` ends where IPOPT ends, from the same start, on windows of a seeded table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmark.runner.run import Workers
from benchmark.runner.tables import read_tables
from benchmark.tasks.suite import Scope
from estimation.status import Status
from suites.execute import run_suites
from suites.optimum.cases import window_bodies, window_case, window_key
from suites.optimum.kinds import KINDS
from suites.optimum.quantities import ABOVE, NEAR
from suites.optimum.reference import IpoptReference
from suites.optimum.run import (
    IPOPT_FAILED,
    IPOPT_SETTINGS,
    NEWEST_LIMIT,
    SAME,
    WindowRow,
    compare,
    compared,
)
from suites.optimum.suite import SUITE
from suites.optimum.tables import windows
from tests.references.gauss_newton import DenseGaussNewton

SHORT = 8
QUICK = [window_key(seed, (SHORT,)) for seed in range(len(window_bodies()) * len(KINDS))]
REPRESENTATIVE = (
    *("turntable accel+gyro", "pen5 accel+gyro", "pen6 accel+gyro+camera"),
    *("classic gas_A_B_C", "classic tank"),
)
"""Models that are always tried; the others are slow to compile."""
MOST_ABOVE, LEAST_SAME = 0.01, 0.97
"""Of windows, in a table of a thousand."""


def listed(rows: Sequence[WindowRow]) -> str:
    return "\n".join(map(str, rows))


@pytest.mark.parametrize(
    "model",
    [
        pytest.param(name, marks=[] if name in REPRESENTATIVE else pytest.mark.slow)
        for name in window_bodies()
    ],
)
def test_the_optimum_is_ipopts(model: str) -> None:
    keys = [key for key in QUICK if key.model == model]
    assert {key.kind for key in keys} == set(window_bodies()[model].kinds)
    rows = [compare(key) for key in keys]
    missed = [row for row in rows if row.verdict == SAME and not row.holds]
    assert not missed, listed(missed)
    # Of a few windows none: but one that is improbable says itself that there may be a lower one.
    above = [row for row in rows if row.verdict == ABOVE]
    assert all(Status.IMPROBABLE in row.status for row in above), listed(above)
    failed = [row for row in rows if row.verdict == IPOPT_FAILED]
    assert all(row.newton_length <= NEWEST_LIMIT for row in failed), listed(failed)


@pytest.mark.slow
def test_the_optimum_is_ipopts_on_a_thousand_windows(tmp_path: Path) -> None:
    scope = Scope(1000)
    run_suites(SUITE.tasks(scope), scope, Workers(2), tmp_path, lambda total: lambda done: None)
    table = windows(read_tables(tmp_path))
    assert list(table["seed"]) == list(range(1000))
    assert set(table["sensors"]) == set(window_bodies())
    differ = table[table[NEAR] == 0]
    assert differ[ABOVE].sum() <= MOST_ABOVE * len(table), differ
    assert table[NEAR].sum() >= LEAST_SAME * len(table), differ
    assert (differ["reason"] != "").all()


@pytest.mark.parametrize(
    "model",
    [
        "turntable accel+gyro",
        pytest.param("pen5 accel", marks=pytest.mark.slow),
        pytest.param("pen6 accel+gyro+camera", marks=pytest.mark.slow),
    ],
)
def test_a_dense_gauss_newton_ends_there_too(model: str) -> None:
    """The reference, the step that judges it and the unit, by an implementation of its own."""
    keys = [key for key in QUICK if key.model == model]
    settings = replace(IPOPT_SETTINGS, horizon=SHORT)
    for case in map(window_case, keys):
        dense, reference = DenseGaussNewton(case.model), IpoptReference(case.model, settings)
        row = compared(case, dense, reference)
        assert row.verdict == SAME, row
        assert row.holds, row
        newest = dense.solve(case.prior, case.measurements, case.guess).newest.covariance
        scale = np.sqrt(np.diag(newest))
        expected = reference.solve(case).solution.newest.covariance
        np.testing.assert_allclose(
            expected / np.outer(scale, scale), newest / np.outer(scale, scale), atol=1e-6
        )
