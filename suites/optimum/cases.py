"""Windows such as a moving-horizon estimator meets, by a key: nothing else is drawn from.

A window is a prior x_k|k-1, N + 1 measurements and a trajectory to start from. The
prior is what an EKF carries at a random instant of a simulated recording, or the
model's own at the recording's start; the guess is rolled out from there without noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmark.configurations import contract_models
from estimation.estimator import Estimator
from estimation.recording import Measurement, Recording
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.names import unknown
from models.pen_file import load_pen
from models.random_streams import stream
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable
from models.units import split_unit
from pen_mhe.estimators import create_estimator
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate, simulate_model
from recordings.simulate_turntable import simulate_table
from suites.optimum.kinds import KINDS, WindowKind

HORIZONS = (20, 20, 20, 5, 20, 20, 20, 40)
"""N of one window after the other."""


PEN_CONFIGURATIONS = ("accel", "gyro", "accel+gyro", "accel+gyro+camera", "two accelerometers")
"""Those of `benchmark.configurations.CONFIGURATIONS` whose windows are solved. One more row there
leaves a seed's window as it was; a row here gives the seeds other windows."""


@cache
def window_models() -> Mapping[str, StateSpaceModel]:
    """Return the models whose windows are solved, by name, pens first."""
    known = contract_models()
    pens = [f"pen{dof} {name}" for dof in (5, 6) for name in PEN_CONFIGURATIONS]
    tables = [name for name in known if name.startswith("turntable")]
    return MappingProxyType({name: known[name] for name in (*pens, *tables)})


@dataclass(frozen=True)
class WindowKey:
    """All that a window depends on.

    Parameters
    ----------
    seed : of everything drawn
    model : one of `window_models`
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


def window_table(
    windows: int, seed: int = 0, horizons: Sequence[int] = HORIZONS
) -> tuple[WindowKey, ...]:
    """Return the keys of a table: models and kinds in turn, no two with the same seed.

    Raises
    ------
    InputError
        If it would be empty.
    """
    if windows < 1:
        raise InputError(f"windows is {windows}, expected at least 1")
    pairs = list(product(KINDS, window_models()))
    keys = []
    for i in range(windows):
        kind, model = pairs[i % len(pairs)]
        # One more step per round: every pair meets every horizon.
        horizon = horizons[(i + i // len(pairs)) % len(horizons)]
        keys.append(WindowKey(seed + i, model, kind, horizon))
    return tuple(keys)


def window_case(key: WindowKey) -> WindowCase:
    """Return the window of a key, always the same one.

    Raises
    ------
    InputError
        If model or kind is unknown.
    """
    if key.model not in window_models():
        raise unknown("model", key.model, window_models())
    if key.kind not in KINDS:
        raise unknown("window kind", key.kind, KINDS)
    model, kind = window_models()[key.model], KINDS[key.kind]
    root = np.random.SeedSequence(key.seed)
    start = stream(root, "start")
    before_s = 0.0 if kind.before_s is None else float(start.uniform(*kind.before_s))
    recording = _recording(key, kind, before_s, stream(root, "motion"))
    measurements = _lossy(model, kind, list(recording.measurements(model)), stream(root, "losses"))
    first = int(np.searchsorted(recording.time_s, before_s))
    window = tuple(measurements[first : first + key.horizon + 1])
    prior = model.prior if kind.before_s is None else _carried(key.model, measurements[: first + 1])
    prior = _wrong(model, prior, kind, start)
    x_0 = prior.mean
    if start.random() < kind.drawn_guess:
        L = np.linalg.cholesky(prior.covariance)
        x_0 = np.asarray(model.retract(x_0, L @ start.standard_normal(model.n_x))).ravel()
    return WindowCase(key, model, prior, window, rolled_out(model, x_0, window))


def rolled_out(
    model: StateSpaceModel, x_0: Array, measurements: Sequence[Measurement]
) -> Trajectory:
    """Return the trajectory without noise from a first state through a window's instants."""
    states, no_noise = [x_0], np.zeros(model.n_w)
    for dt in np.diff([m.time_s for m in measurements]):
        states.append(np.asarray(model.f(states[-1], no_noise, dt)).ravel())
    return Trajectory(np.array(states), np.zeros((len(states) - 1, model.n_w)))


@cache
def _ekf(model: str) -> Estimator[Any]:
    return create_estimator("ekf", window_models()[model])


def _recording(
    key: WindowKey, kind: WindowKind, before_s: float, rng: np.random.Generator
) -> Recording:
    """Simulate long enough for the EKF's run and the window."""
    model = window_models()[key.model]
    rate_hz = max(s.rate_hz for s in model.measured_sensors if s.rate_hz)
    duration_s = before_s + (key.horizon + 2) / rate_hz
    body, seed = key.model.split()[0], int(rng.integers(2**31))
    if body == "turntable":
        if rng.choice(kind.table_motions) == DRAWN:
            return simulate_model(model, duration_s=duration_s, seed=seed)
        return simulate_table(paper_turntable(), duration_s, seed)
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": int(body[3:])})
    motion = str(rng.choice(kind.motions))
    speed = 1.0 if motion == DRAWN else float(rng.uniform(*kind.speed))
    sensors = [sensor.name for sensor in model.measured_sensors]
    return simulate(pen, sensors, motion=motion, duration_s=duration_s, seed=seed, speed=speed)


def _carried(model: str, measurements: Sequence[Measurement]) -> GaussianState:
    """Return x_k|k-1 at the last of the measurements, as an EKF carries it."""
    ekf = _ekf(model)
    state = ekf.init()
    for measurement in measurements[:-1]:
        state, _ = ekf.step(state, measurement)
    nothing = Measurement(measurements[-1].time_s, np.full(ekf.model.n_y, np.nan))
    return ekf.step(state, nothing)[1].state


def _wrong(
    model: StateSpaceModel, prior: GaussianState, kind: WindowKind, rng: np.random.Generator
) -> GaussianState:
    """Move the prior's angles by a distance of the kind in a random direction."""
    angles = angle_directions(model)
    away = angles * rng.standard_normal(model.n_x)
    away *= rng.uniform(*kind.wrong_rad) / np.linalg.norm(away)
    mean = np.asarray(model.retract(prior.mean, away)).ravel()
    return GaussianState(mean, prior.covariance)


def angle_directions(model: StateSpaceModel) -> NDArray[np.bool_]:
    """Return which components of a tangent vector (n_x,) turn something."""
    if model.tangent is not None:
        return np.array([unit == "rad" for unit in model.tangent.units])
    return np.array([split_unit(name)[1] == "rad" for name in model.state_names])


def _lossy(
    model: StateSpaceModel,
    kind: WindowKind,
    measurements: Sequence[Measurement],
    rng: np.random.Generator,
) -> list[Measurement]:
    """Take readings away: single rows, sensors for a while, whole instants, a slow camera's."""
    y = np.array([m.y for m in measurements])
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
    return [Measurement(m.time_s, row) for m, row in zip(measurements, y, strict=True)]
