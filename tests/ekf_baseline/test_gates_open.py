"""A gate that rejects everything opens again, and says how little is known then."""

from __future__ import annotations

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig, EkfState
from ekf_baseline.outliers import OUTLIERS
from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from tests.closeness import estimate_error
from tests.engines import compiled_and_interpreted, needs_compiler
from tests.linear_models import coupled_system

SYSTEM = coupled_system(5)
STEP_S = 0.02
GATED = EkfConfig(gate_probability={"second": 0.999})
LOST = 1.0
"""By how many of the prior's deviations the state is wrong when the track is lost."""


def lost(ekf: Ekf, *, by: float = LOST) -> tuple[EkfState, Array]:
    """A settled state that is sure of the wrong place, and the true one."""
    rng, plain = np.random.default_rng(3), Ekf(SYSTEM.model)
    state = plain.init()
    for measurement in SYSTEM.simulate(np.arange(1, 20) * STEP_S, rng, missing=0.0):
        state, _ = plain.step(state, measurement)
    true = state.gaussian.mean
    wrong = true + by * SYSTEM.model.prior.std
    memory = state.memory.copy()
    state.layout.view(memory, "mean")[:] = wrong
    return EkfState(memory, state.layout), true


def readings(x: Array, k: int, off: float = 0.0) -> Measurement:
    """Second sensor's readings of a truth that moves as the model does, without noise."""
    y = SYSTEM.H @ np.linalg.matrix_power(SYSTEM.F(STEP_S), k) @ x + off
    return Measurement(0.38 + k * STEP_S, np.array([np.nan, *y[1:]]))


def test_it_opens_after_the_time_of_the_table_and_claims_what_it_then_knows() -> None:
    ekf = Ekf(SYSTEM.model, GATED)
    state, true = lost(ekf)
    off, statuses = [], []
    for k in range(1, 20):
        state, estimate = ekf.step(state, readings(true, k))
        error = estimate.state.mean - np.linalg.matrix_power(SYSTEM.F(STEP_S), k) @ true
        off.append(np.abs(error / estimate.state.std).max())
        statuses.append(Status.GATED in estimate.status)
    opens = int(np.ceil(OUTLIERS["GATE_DOUBT_S"] / STEP_S))
    assert statuses == [True] * opens + [False] * (19 - opens)
    assert max(off[:opens]) > 10
    assert max(off[opens:]) < 3
    assert not state.doubt.any()


def test_one_far_reading_never_opens_it() -> None:
    ekf = Ekf(SYSTEM.model, GATED)
    state, true = lost(ekf, by=0.0)
    for k in range(1, 30):
        is_far = k % 2 == 0
        state, estimate = ekf.step(state, readings(true, k, off=500.0 * is_far))
        assert (Status.GATED in estimate.status) == is_far
        assert np.abs((estimate.state.mean - true)[0]) < 50


def test_the_prior_comes_on_top_once_at_most() -> None:
    ekf, plain = Ekf(SYSTEM.model, GATED), Ekf(SYSTEM.model)
    state, true = lost(ekf, by=1e4)
    for k in range(1, 6):
        before = state
        state, estimate = ekf.step(state, readings(true, k))
        if Status.GATED not in estimate.status:
            break
    predicted, _ = plain.step(before, Measurement(0.38 + k * STEP_S, np.full(3, np.nan)))
    P = predicted.gaussian.covariance + SYSTEM.model.prior.covariance
    H, R = SYSTEM.H[1:], SYSTEM.R[1:, 1:]
    known = P - P @ H.T @ np.linalg.solve(H @ P @ H.T + R, H @ P)
    np.testing.assert_allclose(estimate.state.covariance, known, rtol=1e-9)


@needs_compiler
@pytest.mark.parametrize("by", [LOST, 1e4])
def test_both_engines_open_alike(by: float) -> None:
    machine, plain = compiled_and_interpreted(lambda: Ekf(SYSTEM.model, GATED))
    state, true = lost(machine, by=by)
    a, b = state, state
    for k in range(1, 8):
        a, one = machine.step(a, readings(true, k))
        b, other = plain.step(b, readings(true, k))
        assert estimate_error(SYSTEM.model, one, other) < 1e-11
        assert one.status is other.status
        np.testing.assert_array_equal(a.doubt, b.doubt)
