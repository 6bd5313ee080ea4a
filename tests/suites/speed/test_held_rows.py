"""Rows along a window: excess, violation and active rows, in standard deviations."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from suites.speed.held_rows import ACTIVE_STD, HeldRows
from suites.speed.problems import Problem
from suites.speed.windows import SpeedWindow, solved_windows

SCALE = np.array([0.1, 0.2, 2.0, 3.0])


@pytest.fixture(scope="module")
def window() -> SpeedWindow:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estimation.native.compiler", lambda: None)
        return replace(solved_windows(Problem("turntable", 1, 1), 1)[0].window, scale=SCALE)


@pytest.fixture(scope="module")
def held() -> HeldRows:
    """0 ≤ φ, θ̇ ≤ 6, and φ̇ + 2 θ̇ ≤ 0."""
    free = turntable_model(paper_turntable())
    bounded = free.bounded(tilt_phi_rad=(0.0, np.inf), tilt_theta_rate_rad_s=(-np.inf, 6.0))
    return HeldRows(bounded.constrained(lambda x: x[2] + 2 * x[3]))


STATES = np.array([[0.5, 0.0, -20.0, 9.0], [0.0, 0.0, -1.0, 0.0]])


def test_excess_is_in_standard_deviations_of_the_row(held: HeldRows, window: SpeedWindow) -> None:
    """Of a bound it is its state's, of a sum that of independent terms."""
    excess = held.excess(window.measurements, STATES, SCALE)
    both = np.hypot(2.0, 2 * 3.0)
    expected = [[-5.0, 1.0, (-20 + 18) / both], [0.0, -2.0, -1 / both]]
    np.testing.assert_allclose(excess, expected, rtol=1e-12)


def test_violation_is_the_largest_excess_and_never_negative(
    held: HeldRows, window: SpeedWindow
) -> None:
    assert held.violation(window, STATES) == pytest.approx(1.0)
    assert held.violation(window, STATES[[1, 1]] + [0.1, 0, 0, 0]) == 0
    free = HeldRows(window.model)
    assert free.n_c == 0
    assert free.violation(window, STATES) == 0


def test_a_row_is_active_where_it_is_hardly_met(held: HeldRows, window: SpeedWindow) -> None:
    near = STATES[[1, 1]].copy()
    near[0, 0], near[1, 0] = 0.5 * ACTIVE_STD * SCALE[0], 2 * ACTIVE_STD * SCALE[0]
    active = held.active(window.measurements, near, SCALE)
    np.testing.assert_array_equal(active, [[True, False, False], [False, False, False]])


def test_a_row_that_an_instant_does_not_demand_is_not_exceeded(window: SpeedWindow) -> None:
    free: StateSpaceModel = turntable_model(paper_turntable())
    x = ca.SX.sym("x", free.n_x)
    reading = np.zeros((1, free.n_y), dtype=bool)
    reading[0, 0] = True
    model = free.replace(
        inequality=ca.Function("inequality", [x], [x[0]], ["x"], ["g"]), conditions=reading
    )
    first, second = window.measurements
    silent = replace(second, y=np.where(reading[0], np.nan, second.y))
    excess = HeldRows(model).excess((first, silent), STATES[[0, 0]], SCALE)
    np.testing.assert_array_equal(excess.ravel(), [5.0, -np.inf])
