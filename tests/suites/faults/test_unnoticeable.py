"""What explaining a change of readings costs, against the whole linear problem at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import norm

from ekf_baseline.ekf import Ekf
from models.arrays import Array
from models.gaussian import GaussianState
from models.linear_models import linear_model
from suites.faults.table import fault_named, faults
from suites.faults.unnoticeable import (
    LIMIT,
    SEEDS,
    declared,
    response,
    unnoticeable,
    unnoticed_s,
)

N, DT_S = 12, 0.1
A = np.array([[1.0, DT_S, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # place, velocity, bias
C = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
Q = np.diag([1e-4, 1e-2, 1e-6])
R = np.diag([0.04, 0.09])
P = np.diag([1.0, 0.5, 0.2])
TIME_S: Array = np.asarray(DT_S * np.arange(N), dtype=float)


def estimator() -> Ekf:
    prior = GaussianState(np.zeros(3), P)
    return Ekf(linear_model("cart", A, C, Q=Q, R=R, prior=prior, dt_s=DT_S))


def whole_covariance(n: int) -> Array:
    """Covariance of n readings together, from that of all states together."""
    states = np.zeros((3 * n, 3 * n))
    own = P
    for k in range(n):
        own = own if k == 0 else A @ own @ A.T + Q
        block = own
        for j in range(k, n):
            states[3 * j : 3 * j + 3, 3 * k : 3 * k + 3] = block
            states[3 * k : 3 * k + 3, 3 * j : 3 * j + 3] = block.T
            block = A @ block
    reads = block_diag(*[C] * n)
    return np.asarray(reads @ states @ reads.T + block_diag(*[R] * n), dtype=float)


@pytest.fixture(scope="module")
def y() -> Array:
    return np.random.default_rng(5).standard_normal((N, 2))


@pytest.mark.parametrize("kind", ["a bias step", "a spike", "anything"])
def test_the_cost_is_that_of_the_whole_problem(kind: str, y: Array) -> None:
    change = np.zeros((N, 2))
    if kind == "a bias step":
        change[5:, 0] = 0.7
    elif kind == "a spike":
        change[7, 1] = 3.0
    else:
        change = np.random.default_rng(6).standard_normal((N, 2))
    found = response(estimator(), TIME_S, y, y + change)
    for k in range(N):
        part = change[: k + 1].ravel()
        expected = part @ np.linalg.solve(whole_covariance(k + 1), part)
        assert found.cost[k] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_the_shift_is_that_of_the_estimate(y: Array) -> None:
    change = np.zeros((N, 2))
    change[4:, 0] = 0.3
    of = estimator()
    before, after = (of.batch(of.init(), TIME_S, rows)[1] for rows in (y, y + change))
    found = response(of, TIME_S, y, y + change)
    np.testing.assert_allclose(
        found.shift, (after.mean - before.mean) / before.std, rtol=1e-6, atol=1e-9
    )


def test_a_reading_that_is_missing_says_nothing(y: Array) -> None:
    missing, change = y.copy(), np.zeros((N, 2))
    missing[3:6, 0] = np.nan
    change[:, 0] = 0.5
    found = response(estimator(), TIME_S, missing, missing + change)
    kept = ~np.isnan(missing).ravel()
    expected = change.ravel()[kept] @ np.linalg.solve(
        whole_covariance(N)[np.ix_(kept, kept)], change.ravel()[kept]
    )
    assert found.cost[-1] == pytest.approx(expected, rel=1e-6)


def test_what_a_state_explains_costs_little(y: Array) -> None:
    """A first place and bias that nothing contradicts: only the prior does."""
    along = np.tile(C @ np.array([1.0, 0.0, 0.0]), (N, 1))
    found = response(estimator(), TIME_S, y, y + along)
    assert found.cost[-1] < 1 / (P[0, 0] + P[2, 2])


def test_the_limit_is_an_alarm_an_hour() -> None:
    assert norm.sf(np.sqrt(LIMIT)) * 100 * 3600 == pytest.approx(1.0)


def test_unnoticed_is_wrong_before_the_limit() -> None:
    of = estimator()
    found = response(of, TIME_S, np.zeros((N, 2)), np.zeros((N, 2)))
    shift = np.zeros((N, 3))
    shift[2:9, 0] = 5.5
    cost: Array = np.where(np.arange(N) < 6, 0.9 * LIMIT, 2 * LIMIT)
    by_hand = type(found)(TIME_S, cost, shift)
    wrong_s, at_cost = unnoticed_s(by_hand, [0, 1])
    assert wrong_s == pytest.approx(0.4)
    assert at_cost == pytest.approx(0.9 * LIMIT)
    assert unnoticed_s(by_hand, [1]) == (0.0, 0.0)


def test_what_was_declared_is_in_the_table() -> None:
    found = declared()
    assert {each.fault for each in found} <= set(faults())
    assert all(0 <= each.seed < SEEDS and each.cost < LIMIT for each in found)
    assert len({(each.fault, each.sensors) for each in found}) <= 0.05 * 164


def test_what_was_declared_is_found_again() -> None:
    """One run of the file; and one that is not in it, though its fault hurts as much."""
    said = declared()[0]
    found = unnoticeable(fault_named(said.fault), said.sensors, said.seed)
    assert found is not None
    assert found.wrong_s == pytest.approx(said.wrong_s, abs=0.02)
    assert found.cost == pytest.approx(said.cost, rel=0.02)
    assert unnoticeable(fault_named("flipped, accel, x, 1 s"), said.sensors, said.seed) is None


def test_a_fault_of_stamps_is_never_declared() -> None:
    assert unnoticeable(fault_named("jitter, all, 4 ms, 2 s"), "accel+gyro", 0) is None
