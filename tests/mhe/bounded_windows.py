"""Windows with active bounds and inequalities, by a key: nothing else is drawn from.

A truth is drawn from the model itself, with readings of which some are missing; an EKF runs
over the first stages and carries the prior of the window that follows. Truth and first prior
are then moved straight into a constraint row, or out of it, until the window's *free* optimum,
without constraints, stands to the row as wanted: beyond it at a few stages, at many, or just
touching it, so that the row is weakly active, its multiplier next to zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from types import MappingProxyType

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from estimation.kalman_stage import KalmanStage
from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.constraint_rows import constrain_function
from mhe.realtime import Mhe
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from models.noisy_readings import noisy_readings
from models.state_space import StateSpaceModel
from suites.optimum.cases import rolled_out
from tests.mhe.bounded_cases import CASES, bounded_case

HORIZONS = (3, 8, 20)
QUANTILES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"few": (0.55, 0.95), "many": (0.02, 0.35)}
)
"""Placement → part of its stages at which a free optimum keeps to the row, drawn from here."""
TOUCHING = "touching"
TOUCHES = (0.0, -1e-6, 1e-6, -1e-3, 1e-3)
"""By how many standard deviations a free optimum then exceeds the row, one of these."""
PLACEMENTS = (*QUANTILES, TOUCHING)
EKF_STAGES = (5, 25)
ROW_LOSS, INSTANT_LOSS = 0.15, 0.05
LOWEST = 0.35
"""Part of all stages at which a contact touches."""
FARTHEST = 30.0
"""Standard deviations that a free optimum exceeds the row by at most."""
DOUBLINGS = 25
"""Of the first step of the search, 1e-3 standard deviations of the prior."""


@dataclass(frozen=True)
class BoundedKey:
    """All that a window depends on."""

    seed: int
    case: str
    placement: str
    horizon: int


@dataclass(frozen=True, eq=False)
class BoundedWindow:
    """A window to solve.

    Parameters
    ----------
    free : its optimum without constraints
    std : (n_x,) standard deviations of the newest state there
    """

    key: BoundedKey
    prior: GaussianState
    measurements: tuple[Measurement, ...]
    guess: Trajectory
    free: Trajectory
    std: Array


def bounded_table(windows: int, seed: int = 0) -> tuple[BoundedKey, ...]:
    """Return keys: cases, horizons and placements in turn, every key with its own seed."""
    kinds = list(product(PLACEMENTS, HORIZONS, CASES))
    return tuple(
        BoundedKey(seed + i, case, placement, horizon)
        for i in range(windows)
        for placement, horizon, case in [kinds[i % len(kinds)]]
    )


def bounded_window(key: BoundedKey) -> BoundedWindow:
    """Return the window of a key, always the same one."""
    draw, rng = _drawn(key), np.random.default_rng([key.seed, 1])
    search = _Search(key, draw)
    if key.placement == TOUCHING:
        touch = float(rng.choice(TOUCHES))
        search.place(lambda excess, std: float(excess.max()) - touch * std, exact=True)
    else:
        part = float(rng.uniform(*QUANTILES[key.placement]))

        def judge(excess: Array, std: float) -> float:
            return max(float(np.quantile(excess, part)), float(excess.max()) - FARTHEST * std)

        search.place(judge, exact=False)
    return search.found


@dataclass(frozen=True, eq=False)
class _Draw:
    """What a window is made of, apart from where it lies.

    Parameters
    ----------
    times : (n,) of all stages, those of the EKF first
    start, shocks : (n_x,), (n - 1, n_w) unit draws of the truth
    noise : (n, n_r) unit draws of the readings
    there : (n, n_y) readings that are not missing
    """

    times: Array
    start: Array
    shocks: Array
    noise: Array
    there: NDArray[np.bool_]


def _drawn(key: BoundedKey) -> _Draw:
    rng, case = np.random.default_rng([key.seed, 0]), bounded_case(key.case)
    model, n = case.free, key.horizon + 1 + int(rng.integers(*EKF_STAGES))
    there = (rng.random((n, model.n_y)) > ROW_LOSS) & (rng.random((n, 1)) > INSTANT_LOSS)
    phase, column = rng.integers(3), 0
    for sensor in model.sensors:
        own = slice(column, column + sensor.n_y)
        column += sensor.n_y
        if sensor.name in case.slow:
            there[:, own] = (np.arange(n) % 3 == phase)[:, None]
    return _Draw(
        np.cumsum(case.step_s * rng.uniform(0.5, 1.5, n)),
        rng.standard_normal(model.n_x),
        rng.standard_normal((n - 1, model.n_w)),
        rng.standard_normal((n, model.n_r)),
        there,
    )


class _Search:
    """Moves a window along a row's slope until its free optimum is where it should be."""

    def __init__(self, key: BoundedKey, draw: _Draw) -> None:
        self._key, self._draw, self._case = key, draw, bounded_case(key.case)
        self._direction = np.zeros(self._case.free.n_x)
        self.found = self._window(0.0)
        slope = self._slope(self.found)
        self._direction = slope / np.linalg.norm(slope)

    def place(self, judge: Callable[[Array, float], float], exact: bool) -> None:
        """Find where a function of the free optimum's excess over the row is zero.

        Parameters
        ----------
        judge : (excess (n,), its standard deviation) → a number that rises with the excess
        exact : to rounding, else roughly
        """

        def judged(by: float) -> float:
            self.found = self._window(by)
            return judge(*self._excess(self.found))

        step = 1e-3 * float(np.abs(self._direction) @ self._case.free.prior.std)
        value, here = judged(0.0), 0.0
        there, way = here, -np.sign(value)
        for _ in range(DOUBLINGS):
            there += way * step
            if np.sign(judged(there)) != np.sign(value):
                break
            here, step = there, 2 * step
        else:
            raise AssertionError(f"{self._key}: no place found")
        tolerance = 4 * np.finfo(float).eps if exact else 1e-3
        by = brentq(judged, here, there, xtol=1e-300 if exact else 1e-3 * step, rtol=tolerance)
        self.found = self._window(by)

    def _window(self, by: float) -> BoundedWindow:
        """Move truth and first prior; return the window with its free optimum."""
        key, draw, case = self._key, self._draw, self._case
        model, stage = case.free, _stage(key.case)
        mean = model.prior.mean + by * self._direction
        L = np.linalg.cholesky(model.prior.covariance)
        truth = [mean + case.spread * L @ draw.start]
        for w, dt in zip(draw.shocks, np.diff(draw.times), strict=True):
            truth.append(np.asarray(model.f(truth[-1], w, dt)).ravel())
        y = _readings(model, np.array(truth), draw)
        first, prior = len(y) - key.horizon - 1, GaussianState(mean, model.prior.covariance)
        for k in range(first):
            after = stage.update(prior, y[k]).state
            prior = stage.predict(after, float(draw.times[k + 1] - draw.times[k])).state
        rows = zip(draw.times[first:], y[first:], strict=True)
        window = tuple(Measurement(float(time_s), row) for time_s, row in rows)
        guess = rolled_out(model, prior.mean, window)
        free = _free(key.case, key.horizon).solve(prior, window, guess)
        assert free.status.is_solved, (key, free.status.label, free.iterations)
        return BoundedWindow(key, prior, window, guess, free.trajectory, free.newest.std)

    def _excess(self, window: BoundedWindow) -> tuple[Array, float]:
        """Return what the free optimum exceeds the row by, (n,), and a standard deviation of it."""
        rows, row = _constraints(self._key.case), self._case.row
        excess = np.array([float(rows(x)[0][row]) for x in window.free.states])
        return excess, float(np.linalg.norm(self._slope(window) * window.std))

    def _slope(self, window: BoundedWindow) -> Array:
        """Return the row's derivative (n_x,) at the newest stage."""
        return _constraints(self._key.case)(window.free.states[-1])[1].full()[:, self._case.row]


def _readings(model: StateSpaceModel, truth: Array, draw: _Draw) -> Array:
    """Return y (n, n_y); a contact reads its height where the tip is lowest, wherever that is."""
    y, row = [], 0
    for sensor in model.sensors:
        noise = sensor.noise_std * draw.noise[:, row : row + sensor.n_r]
        row += sensor.n_r
        if sensor.touched_height is not None:
            height = sensor.h(truth.T).full().T
            low = height <= np.quantile(height, LOWEST)
            y.append(np.where(low, sensor.touched_height, np.nan))
        else:
            y.append(noisy_readings(sensor, truth, noise))
    return np.where(draw.there, np.hstack(y), np.nan)


@cache
def _stage(case: str) -> KalmanStage:
    return KalmanStage(bounded_case(case).free)


@cache
def _free(case: str, horizon: int) -> Mhe:
    settings = MheConfig(horizon=horizon, tolerance=1e-11, max_iterations=3000)
    return Mhe(bounded_case(case).free, settings)


@cache
def _constraints(case: str) -> ca.Function:
    return constrain_function(bounded_case(case).bounded)
