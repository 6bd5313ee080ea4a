"""Pens that are held still, turn slowly or tremble: their readings, and errors beside claims."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from estimation.outputs import outputs_of
from estimation.recording import Recording, Truth
from models import attitude
from models.arrays import Array
from models.motions import SampledMotion
from models.pen_config import PenConfig
from models.random_streams import seed_sequence
from models.simulation import sample_times, simulate_readings, true_states, union_of_times
from models.state_space import StateSpaceModel

Movement = Callable[[ca.SX, Array, np.random.Generator], ca.SX]
"""(t, first q (6,), draws) → q(t) (6,): tip, azimuth, elevation, spin."""
PART = 20_000
"""Steps per call: what they say of a long run would not fit in memory."""


def still(t: ca.SX, q: Array, rng: np.random.Generator) -> ca.SX:
    """Nothing moves."""
    return ca.SX(q) + 0 * t


def picked_up(after_s: float) -> Movement:
    """Still, then a hand that waves it about."""

    def moved(t: ca.SX, q: Array, rng: np.random.Generator) -> ca.SX:
        begun = 1 / (1 + ca.exp(-(t - after_s - 0.5) / 0.1))
        size = np.array([0.03, 0.03, 0.02, 0.4, 0.25, 0.3])
        phase, rate = rng.uniform(0, 2 * np.pi, 6), rng.uniform(1.5, 3.5, 6)
        return ca.SX(q) + begun * (ca.SX(size) * ca.sin(rate * t + phase))

    return moved


def turning(rate_rad_s: float) -> Movement:
    """Steadily about the vertical."""

    def moved(t: ca.SX, q: Array, rng: np.random.Generator) -> ca.SX:
        return ca.SX(q) + rate_rad_s * t * ca.SX(np.eye(6)[3])

    return moved


def trembling(tip_m: float, rate_rad_s: float) -> Movement:
    """8 to 12 Hz in all six; three waves each, that together have these amplitudes."""

    def moved(t: ca.SX, q: Array, rng: np.random.Generator) -> ca.SX:
        omega, phase = 2 * np.pi * rng.uniform(8, 12, (6, 3)), rng.uniform(0, 2 * np.pi, (6, 3))
        size = np.array([[tip_m]] * 3 + [[rate_rad_s]] * 3) / np.sqrt(3) * np.ones((6, 3))
        size[3:] /= omega[3:]
        return ca.SX(q) + ca.sum2(ca.DM(size) * ca.sin(ca.DM(omega) * t + ca.DM(phase)))

    return moved


def recorded(
    pen: PenConfig, model: StateSpaceModel, movement: Movement, *, duration_s: float, seed: int
) -> Recording:
    """Simulate a pen whose attitude is drawn from its prior."""
    rng, prior = np.random.default_rng(1000 + seed), pen.prior
    elevation = np.inf
    while abs(elevation) > np.pi / 2 - 0.05:
        elevation = prior.elevation_rad + prior.elevation_std_rad * rng.standard_normal()
    azimuth = prior.azimuth_rad + prior.azimuth_std_rad * rng.standard_normal()
    spin = prior.spin_rad + prior.spin_std_rad * rng.standard_normal()
    t = ca.SX.sym("t")
    q = movement(t, np.array([*prior.tip_m, azimuth, elevation, spin]), rng)
    q_dot = ca.jacobian(q, t)
    path = ca.Function("path", [t], [q, q_dot, ca.jacobian(q_dot, t)])
    times = sample_times(model, duration_s)
    time_s, root = union_of_times(times), seed_sequence(seed)
    along = (ca.densify(part).full().T for part in path(time_s[None, :]))
    states = true_states(model, SampledMotion("own", time_s, *along), root, times=times)
    outputs = outputs_of(model)
    more = [name for name in outputs.names if name not in model.state_names]
    values = outputs.function(states.T).full().T[:, [outputs.names.index(name) for name in more]]
    readings = simulate_readings(model, times, time_s, states, root).sensors
    return Recording.from_sensors(
        "pen",
        {name: (times[name], values) for name, (_, values) in readings.items()},
        truth=Truth(time_s, (*model.state_names, *more), np.hstack([states, values])),
    )


@dataclass(frozen=True)
class Judged:
    """Errors and claims (std) at some instants (n,): elevation, rad, and the gyroscope's bias about
    the vertical, rad/s."""

    error: Array
    claimed: Array
    bias_error: Array
    bias_claimed: Array


def judged(estimator: Any, recording: Recording, instants_s: Sequence[float]) -> Judged:
    """Run an estimator and judge it at some instants."""
    model: StateSpaceModel = estimator.model
    time_s, y = recording.stacked(model)
    assert recording.truth is not None
    sigma = [model.state_names.index(f"mrp_{axis}") for axis in "xyz"]
    bias = [model.state_names.index(name) for name in model.sensor("gyro").bias_states]
    state, start, rows = estimator.init(), 0, []
    for instant in instants_s:
        end = int(np.searchsorted(time_s, instant + 1e-6))
        while start < end - 1:
            part = slice(start, min(start + PART, end - 1))
            state, _ = estimator.batch(state, time_s[part], y[part])
            start = part.stop
        state, last = estimator.batch(state, time_s[start:end], y[start:end], covariances=True)
        start = end
        x, P = last.mean[-1], last.covariances.state[-1][np.ix_(bias, bias)]
        true = recording.truth.states(model.state_names, last.time_s[-1:])[0]
        up = _up(x[sigma])
        index = last.index("elevation_rad")
        error = last.errors(recording.truth)[-1, index]
        claimed = last.std_of("elevation_rad")[-1]
        rows.append((error, claimed, up @ (x[bias] - true[bias]), np.sqrt(up @ P @ up)))
    return Judged(*np.array(rows).T)


def _up(sigma: Array) -> Array:
    """Return the vertical in body axes (3,)."""
    return np.asarray(ca.evalf(attitude.body_to_world(ca.SX(sigma))[2, :]).full().ravel())


def off_by(estimator: Any, recording: Recording) -> Array:
    """Return errors of elevation over their claims (n,) from the first second on."""
    time_s, y = recording.stacked(estimator.model)
    _, history = estimator.batch(estimator.init(), time_s, y)
    errors = history.errors(recording.truth)[:, history.index("elevation_rad")]
    ratio: Array = errors / history.std_of("elevation_rad")
    return ratio[history.time_s > time_s[0] + 1]
