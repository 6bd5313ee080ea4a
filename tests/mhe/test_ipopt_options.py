"""IPOPT's own options: passed on, or refused in a sentence when they are given."""

from __future__ import annotations

from typing import Any

import pytest

from estimation.estimator import run_measurements
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.errors import InputError
from pen_mhe.estimators import create_estimator
from tests.mhe import pendulum

pytestmark = pytest.mark.usefixtures("interpreted")


def test_they_come_before_the_settings() -> None:
    """Of a limit of one iteration, that the window says it has reached."""
    model, some = pendulum.model(), pendulum.simulate(3, 1)
    given = {"max_iter": 1, "linear_solver": "mumps", "mu_strategy": "adaptive"}
    estimator = MheIpopt(model, MheIpoptConfig(horizon=4, max_iterations=50, ipopt=given))
    history = run_measurements(estimator, some)
    assert set(history.status) == {Status.ITERATION_LIMIT}
    assert max(history.iterations) == 1
    assert estimator.config.ipopt == given


def test_yes_may_be_true() -> None:
    config = MheIpoptConfig(ipopt={"mehrotra_algorithm": False, "sb": True})
    assert config.ipopt == {"mehrotra_algorithm": "no", "sb": "yes"}


@pytest.mark.parametrize(
    ("ipopt", "sentence"),
    [
        ({"max_itr": 5}, "IPOPT option max_itr is unknown, expected one of https"),
        ({"max_iter": "many"}, "IPOPT option max_iter is 'many', expected a whole number"),
        ({"tol": "1e-3"}, "IPOPT option tol is '1e-3', expected a number"),
        ({"linear_solver": 3}, "IPOPT option linear_solver is 3, expected a text"),
        ({"tol": -1.0}, r"IPOPT option tol is -1.0, expected 0 < \(1e-08\) <= \+inf"),
        ({"linear_solver": "fast"}, "IPOPT option linear_solver is 'fast', expected one of ma27, "),
        ({"linear_solver": "pardiso"}, "is 'pardiso', which this IPOPT does not have, expected an"),
        ({"tol": [1]}, r"IPOPT option tol is \[1\], expected a number or a text"),
        (["tol"], r"ipopt is \['tol'\], expected IPOPT's options by name"),
    ],
)  # fmt: skip
def test_others_are_refused_at_once(ipopt: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        create_estimator("mhe-ipopt", pendulum.model(), ipopt=ipopt)
