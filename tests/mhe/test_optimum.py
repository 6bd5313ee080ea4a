"""`mhe` ends where IPOPT ends, from the same start, on windows of a seeded table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from estimation.status import Status
from suites.optimum.cases import window_bodies, window_case, window_table
from suites.optimum.kinds import KINDS
from suites.optimum.reference import IpoptReference
from suites.optimum.run import (
    ABOVE,
    IPOPT_FAILED,
    IPOPT_SETTINGS,
    SAME,
    WindowRow,
    WindowSummary,
    compare,
    compared,
    summary,
)
from suites.optimum.study import compare_all
from tests.references.gauss_newton import DenseGaussNewton

SHORT = 8
QUICK = window_table(len(window_bodies()) * len(KINDS), horizons=(SHORT,))
REPRESENTATIVE = (
    *("turntable accel+gyro", "pen5 accel+gyro", "pen6 accel+gyro+camera"),
    *("classic gas_A_B_C", "classic tank"),
)
"""Models that are always tried; the others are slow to compile."""
MOST_ABOVE, LEAST_SAME = 0.01, 0.97
"""Of windows, in a table of a thousand."""


def listed(rows: Sequence[WindowRow]) -> str:
    return "\n".join(map(str, rows))


def check(rows: Sequence[WindowRow]) -> WindowSummary:
    found = summary(rows)
    assert not found.missed, listed(found.missed)
    # Of a few windows none: but one that is improbable says itself that there may be a lower one.
    unsaid = [row for row in found.above if Status.IMPROBABLE not in row.status]
    assert not unsaid, listed(unsaid)
    return found


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
    found = check([compare(key) for key in keys])
    assert found.near_anyway == found.verdicts[IPOPT_FAILED], listed(found.ipopt_failed)


@pytest.mark.slow
def test_the_optimum_is_ipopts_on_a_thousand_windows(tmp_path: Path) -> None:
    rows = compare_all(window_table(1000), tmp_path, jobs=2)
    assert {row.key.model for row in rows} == set(window_bodies())
    found = summary(rows)
    assert found.verdicts[ABOVE] <= MOST_ABOVE * len(rows), listed(found.above)
    assert found.verdicts[SAME] - len(found.missed) >= LEAST_SAME * len(rows), listed(found.missed)
    assert all(bool(row.reason) != (row.verdict == SAME and row.holds) for row in rows)


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
