"""Where `mhe-ipopt` ends: by the length of its steps, whatever rounding does to gradients."""

from __future__ import annotations

import pytest

from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from mhe.reference.ipopt_solver import STANDS, status_of
from suites.optimum.cases import WindowKey, window_case
from suites.optimum.newton_step import NewtonCheck

GYRO_FREE, HORIZON = "gyro-free two accels", 10


def test_a_stiff_reading_of_a_loose_state_does_not_keep_it_from_ending() -> None:
    """Its gradients round to 1e-6; the steps are down to 1e-10 deviations in ten iterations."""
    settings = MheIpoptConfig(horizon=HORIZON)
    model = window_case(WindowKey(0, GYRO_FREE, "plain", HORIZON)).model
    mhe, check = MheIpopt(model, settings), NewtonCheck(model, settings)
    for seed in (1, 2):
        case = window_case(WindowKey(seed, GYRO_FREE, "plain", HORIZON))
        found = mhe.solve(case.prior, case.measurements, case.guess)
        assert found.status is Status.SOLVED
        assert found.iterations < 30
        left = check.step(case.prior, case.measurements, found.trajectory, found.newest.std)
        assert left.length < 10 * settings.tolerance


@pytest.mark.parametrize(
    ("said", "violation", "status"),
    [
        (STANDS, 1e-9, Status.SOLVED),
        (STANDS, 1e-7, Status.SOLVER_FAILED),
        ("Solve_Succeeded", 1e-7, Status.SOLVED),
        ("Solved_To_Acceptable_Level", 1e-9, Status.SOLVER_FAILED),
        ("Infeasible_Problem_Detected", 1.0, Status.INFEASIBLE),
    ],
)
def test_standing_still_is_solved_where_the_constraints_hold(
    said: str, violation: float, status: Status
) -> None:
    stats = {"return_status": said, "iterations": {"inf_pr": [1.0, violation]}}
    assert status_of(stats, tolerance=1e-8) is status
