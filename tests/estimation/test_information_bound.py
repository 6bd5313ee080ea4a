"""The information bound of a nonlinear transition: the textbook's recursion at the true states."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.information_bound import information_bound
from tests.mhe import pendulum

pytestmark = pytest.mark.usefixtures("interpreted")


def test_a_pendulums_bound_is_linearised_where_each_step_begins() -> None:
    """P⁻ = F P Fᵀ + G Gᵀ with F at the state before; P⁻¹ + Hᵀ R⁻¹ H with H at the state itself."""
    measurements, rng = pendulum.simulate(30, seed=4), np.random.default_rng(4)
    states = [np.array([0.4, 1.0])]
    times = [m.time_s for m in measurements]
    for dt in np.diff(times):
        states.append(pendulum.step(states[-1], rng.standard_normal(2), float(dt)))
    bound = information_bound(pendulum.model(), measurements, np.array(states))
    P, previous = np.diag(pendulum.PRIOR_STD**2), None
    for k, (measurement, x) in enumerate(zip(measurements, states, strict=True)):
        if previous is not None:
            F, G = pendulum.derivatives(previous, np.zeros(2), times[k] - times[k - 1])
            P = F @ P @ F.T + G @ G.T
        H = np.array([[np.cos(x[0]), 0.0], [0.0, 1.0]])
        R = np.diag([pendulum.SINE_STD, pendulum.RATE_STD]) ** 2
        seen = np.isfinite(measurement.y)
        H, R = H[seen], R[np.ix_(seen, seen)]
        P = np.linalg.inv(np.linalg.inv(P) + H.T @ np.linalg.solve(R, H))
        assert bound.std[k] == pytest.approx(np.sqrt(np.diag(P)), rel=1e-8)
        previous = x
    assert np.ptp(np.array(states)[:, 0]) > 1.0, "cos θ hardly changes"
