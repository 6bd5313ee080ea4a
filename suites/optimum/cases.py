"""Windows such as a moving-horizon estimator meets, by a key: nothing else is drawn from.

A window is a prior x_k|k-1, N + 1 measurements and a trajectory to start from. The
prior is what an EKF carries at a random instant of a simulated recording, or the
model's own at the recording's start; the guess is rolled out from there without noise. An EKF
knows no bounds: where a model has some, the prior is what a moving-horizon estimator carries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.estimator import Estimator
from estimation.inputs import all_with_inputs, without_readings
from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import Mhe
from mhe.trajectory import Trajectory, driven
from mhe.window_memory import View, window_memory
from models.arrays import Array
from models.gaussian import GaussianState
from models.names import unknown
from models.random_streams import stream
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from suites.optimum.kinds import KINDS, WindowKind
from suites.optimum.pens import own_bodies
from suites.windows import WindowBody, lent_bodies

HORIZONS = (20, 20, 20, 5, 20, 20, 20, 40)
"""N of one window after the other."""


@cache
def window_bodies() -> Mapping[str, WindowBody]:
    """Return what windows are cut from, by name: pens first, then what other suites lend."""
    return MappingProxyType({**own_bodies(), **lent_bodies()})


@dataclass(frozen=True)
class WindowKey:
    """All that a window depends on.

    Parameters
    ----------
    seed : of everything drawn
    model : one of `window_bodies`
    kind : one of `KINDS`
    horizon : N, intervals
    """

    seed: int
    model: str
    kind: str
    horizon: int


@dataclass(frozen=True, eq=False)
class WindowCase:
    """A window to solve; the arguments of ``solve`` and the model they belong to."""

    key: WindowKey
    model: StateSpaceModel
    prior: GaussianState
    measurements: tuple[Measurement, ...]
    guess: Trajectory


def window_key(seed: int, horizons: tuple[int, ...] = HORIZONS) -> WindowKey:
    """Return the key of a seed: bodies in turn, each with its kinds in turn.

    Parameters
    ----------
    horizons : N of one window after the other, of bodies that have none of their own
    """
    bodies = list(window_bodies().items())
    turn, place = divmod(seed, len(bodies))
    name, body = bodies[place]
    kind = body.kinds[turn % len(body.kinds)]
    lengths = body.horizons.get(kind) or horizons
    horizon = lengths[(place + turn // len(body.kinds)) % len(lengths)]
    return WindowKey(seed, name, kind, horizon)


def window_case(key: WindowKey) -> WindowCase:
    """Return the window of a key, always the same one.

    Raises
    ------
    InputError
        If model or kind is unknown.
    """
    if key.model not in window_bodies():
        raise unknown("model", key.model, window_bodies())
    body = window_bodies()[key.model]
    if key.kind not in body.kinds:
        raise unknown("window kind", key.kind, body.kinds)
    model, kind = body.model, KINDS[key.kind]
    root = np.random.SeedSequence(key.seed)
    start = stream(root, "start")
    span = kind.before_s and (body.before_s or kind.before_s)
    before_s = float(start.uniform(*span)) if span else 0.0
    duration_s = before_s + (key.horizon + 2) * body.step_s
    recording, prior = body.record(key.kind, duration_s, stream(root, "motion"))
    measurements = _lossy(model, kind, list(recording.measurements(model)), stream(root, "losses"))
    first = int(np.searchsorted(recording.time_s, before_s))
    window = tuple(measurements[first : first + key.horizon + 1])
    if span:
        prior = _carried(key, prior, measurements[:first], window)
    prior = _wrong(model, prior, kind, start)
    x_0 = prior.mean
    if start.random() < kind.drawn_guess:
        L = np.linalg.cholesky(prior.covariance)
        x_0 = np.asarray(model.retract(x_0, L @ start.standard_normal(model.n_x))).ravel()
    x_0 = np.clip(x_0, model.lower, model.upper)
    return WindowCase(key, model, prior, window, rolled_out(model, x_0, window))


def rolled_out(
    model: StateSpaceModel, x_0: Array, measurements: Sequence[Measurement]
) -> Trajectory:
    """Return the trajectory without noise from a first state through a window's instants."""
    no_noises = np.zeros((len(measurements) - 1, model.n_w))
    return driven(model, x_0, no_noises, all_with_inputs(model, measurements))


@cache
def _ekf(model: str) -> Estimator[Any]:
    return create_estimator("ekf", window_bodies()[model].model, huber={})


@cache
def _mhe(model: str, horizon: int) -> Mhe:
    return Mhe(window_bodies()[model].model, MheConfig(horizon=horizon))


def _carried(
    key: WindowKey,
    prior: GaussianState,
    before: Sequence[Measurement],
    window: Sequence[Measurement],
) -> GaussianState:
    """Return x_k|k-1 at a window's first instant, given the measurements before it."""
    model = window_bodies()[key.model].model
    if np.isfinite(np.concatenate([model.lower, model.upper])).any():
        mhe = _mhe(key.model, key.horizon)
        held = mhe.init(prior)
        for measurement in (*before, *window):
            held, _ = mhe.step(held, measurement)
        return View.of(window_memory(model, key.horizon + 1), held.memory).prior
    ekf = _ekf(key.model)
    state = ekf.init(prior)
    for measurement in before:
        state, _ = ekf.step(state, measurement)
    nothing = Measurement(window[0].time_s, without_readings(model, window[0].y))
    return ekf.step(state, nothing)[1].state


def _wrong(
    model: StateSpaceModel, prior: GaussianState, kind: WindowKind, rng: np.random.Generator
) -> GaussianState:
    """Move the prior's angles by a distance of the kind in a random direction."""
    angles = angle_directions(model)
    away = angles * rng.standard_normal(model.n_x)
    distance, length = rng.uniform(*kind.wrong_rad), np.linalg.norm(away)
    if length:
        away *= distance / length
    mean = np.asarray(model.retract(prior.mean, away)).ravel()
    return GaussianState(mean, prior.covariance)


def angle_directions(model: StateSpaceModel) -> NDArray[np.bool_]:
    """Return which components of a tangent vector (n_x,) turn something."""
    if model.tangent is not None:
        return np.array([unit == "rad" for unit in model.tangent.units])
    return np.array([unit == "rad" for unit in model.state_units])


def _lossy(
    model: StateSpaceModel,
    kind: WindowKind,
    measurements: Sequence[Measurement],
    rng: np.random.Generator,
) -> list[Measurement]:
    """Take readings away: single rows, sensors for a while, whole instants, a slow camera's."""
    rows = np.array([m.y for m in measurements])
    y = rows[:, : model.n_y]  # known inputs stay
    n = len(y)
    y[rng.random(y.shape) < kind.row_loss] = np.nan
    y[rng.random(n) < kind.instant_loss] = np.nan
    column, every = 0, int(rng.integers(1, kind.slowest + 1))
    for sensor in model.sensors:
        columns = slice(column, column + sensor.n_y)
        column += sensor.n_y
        if rng.random() < kind.sensor_loss:
            first, last = np.sort(rng.integers(0, n + 1, 2))
            y[first:last, columns] = np.nan
        if sensor.sees_pose:
            there = np.flatnonzero(np.isfinite(y[:, columns]).any(axis=1))
            y[np.setdiff1d(there, there[::every]), columns] = np.nan
    return [Measurement(m.time_s, row) for m, row in zip(measurements, rows, strict=True)]
