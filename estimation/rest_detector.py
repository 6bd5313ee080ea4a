"""The detector of estimation/rest.c in Python; its rule is written down in `estimation.rest`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimation.layout import Layout
from estimation.rest import (
    BLOCKS,
    FEWEST,
    GAP,
    HALVES,
    NEWEST,
    PATIENCE,
    block_s,
    detected_rest,
    rest_axes,
    rest_blocks,
)
from models.arrays import Array
from models.sensor_model import RestRule
from models.state_space import StateSpaceModel

WINDOW = ("rest_closed", "rest_since", "rest_age", "rest_n", "rest_mean", "rest_square")
"""Blocks of the state that begin anew with the window."""


class RestDetector:
    """The detector in Python; its state is one flat array, see `rest_blocks`."""

    def __init__(self, model: StateSpaceModel) -> None:
        sensor = detected_rest(model)
        self._rule = None if sensor is None else sensor.rest
        self.layout = Layout("RestMemory", rest_blocks(model))
        if sensor is not None:
            self._axes = rest_axes(model)
            self._limit = model.saturation[self._axes.column]

    def part(self, layout: Layout, memory: Array) -> Array:
        """Return the detector's part of an estimator's state, a view."""
        if self._rule is None:
            return memory[:0]
        start = layout.slices[next(iter(self.layout.shapes))].start
        return memory[start : start + self.layout.size]

    def first(self) -> Array:
        """Return the state before the first measurement."""
        return np.zeros(self.layout.size)

    def step(self, given: Array, dt: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement, and its readings with that of rest.

        Parameters
        ----------
        given : the state before; it stays
        dt : since the measurement before, s; 0 for the first
        y : (n_y,) readings, NaN where there is none
        """
        if self._rule is None:
            return given, y
        memory, axes, rule = given.copy(), self._axes, self._rule
        at = {block: self.layout.view(memory, block) for block in self.layout.shapes}
        readings = y[axes.column]
        present = ~np.isnan(readings)
        at["rest_ago"][...] += dt
        goes_on = self._take(at, dt, readings, rule)
        own = slice(axes.first, axes.first + axes.count)
        if np.isfinite(y[own]).any():
            at["rest_told"][...] = 1
        turns = present & (axes.gyroscope >= 0)
        if at["rest_told"] == 0 and turns.any() and goes_on and self._rests(at, dt, readings, rule):
            y = y.copy()
            y[own] = 0
        return memory, y

    def _take(self, at: Mapping[str, Array], dt: float, readings: Array, rule: RestRule) -> bool:
        """Put readings into the block that is being filled; return whether rest may go on."""
        present = ~np.isnan(readings)
        at["rest_since"][...] += dt
        if not present.any():
            return False
        is_disturbed = not (np.abs(readings) < self._limit)[present].all()
        if is_disturbed or at["rest_since"] > GAP * rule.window_s:
            for name in WINDOW:
                at[name][...] = 0
        k = int(at["rest_closed"])
        at["rest_age"][k] += at["rest_since"]
        at["rest_since"][...] = 0
        if is_disturbed:
            return False
        n, mean, square = (at[name][k] for name in ("rest_n", "rest_mean", "rest_square"))
        n[present] += 1
        away = readings[present] - mean[present]
        mean[present] += away / n[present]
        square[present] += away * (readings[present] - mean[present])
        if at["rest_age"][k] >= block_s(rule.window_s):
            _close(at)
        return True

    def _rests(self, at: Mapping[str, Array], dt: float, readings: Array, rule: RestRule) -> bool:
        """Return whether the body rests, `dt` after the measurement before."""
        n, mean, is_still = self._still(at, readings, rule)
        if not is_still:
            at["rest_waits"][...] = 0
            return False
        if at["rest_known"] != 0 and not self._is_known(at, n, mean):
            at["rest_waits"][...] += dt
            if not at["rest_waits"] > PATIENCE * rule.window_s:
                return False
        at["rest_known"][...] = 1
        at["rest_ago"][...] = at["rest_waits"][...] = 0
        at["rest_bias"][:] = mean
        return True

    def _is_known(self, at: Mapping[str, Array], n: Array, mean: Array) -> bool:
        """Return whether a still body's rate is that of the last rest, but for a bias' walk."""
        axes = self._axes
        apart, more = np.zeros(len(axes.largest_square)), mean - at["rest_bias"]
        variance = np.square(axes.noise_std)
        for i in np.flatnonzero(axes.gyroscope >= 0):
            apart[axes.gyroscope[i]] += (
                more[i] * more[i]
                - 2 * HALVES * HALVES * variance[i] / n[i]
                - axes.walk_square[i] * at["rest_ago"]
            )
        return bool((apart < 0).all())

    def _still(
        self, at: Mapping[str, Array], readings: Array, rule: RestRule
    ) -> tuple[Array, Array, bool]:
        """Return numbers and means of the window, and whether it is that of a still body."""
        if at["rest_closed"] < BLOCKS:
            return readings, readings, False
        axes, half = self._axes, BLOCKS // 2
        n_1, mean_1, square_1 = _joined(at, 0, half)
        n_2, mean_2, square_2 = _joined(at, half, BLOCKS + 1)
        if (n_1 < FEWEST).any() or (n_2 < FEWEST).any():
            return n_1, mean_1, False
        n, apart, variance = n_1 + n_2, mean_2 - mean_1, np.square(axes.noise_std)
        mean = mean_1 + apart * n_2 / n
        square = square_1 + square_2 + apart * apart * n_1 * n_2 / n
        chance = HALVES * HALVES * (1 / n_1 + 1 / n_2)
        spread = rule.spread_factor * rule.spread_factor * variance
        away = np.where(np.isnan(readings), 0.0, readings - mean)
        is_still = (
            (square < spread * (n - 1))
            & ((square > 0) | axes.may_repeat)
            & (apart * apart < np.maximum(1.0, chance) * variance)
            & (away * away < NEWEST * NEWEST * spread)
        )
        turn = -axes.largest_square
        for i in np.flatnonzero(axes.gyroscope >= 0):
            turn[axes.gyroscope[i]] += mean[i] * mean[i] - HALVES * HALVES * variance[i] / n[i]
        return n, mean, bool(is_still.all() and (turn < 0).all())


def _close(at: Mapping[str, Array]) -> None:
    """Close the block that is being filled; the oldest goes where there are enough."""
    moved = [at[name] for name in ("rest_age", "rest_n", "rest_mean", "rest_square")]
    if at["rest_closed"] < BLOCKS:
        at["rest_closed"][...] += 1
        return
    for block in moved:
        block[:-1] = block[1:].copy()
        block[-1] = 0


def _joined(at: Mapping[str, Array], first: int, end: int) -> tuple[Array, Array, Array]:
    """Return numbers, means and sums of squared deviations (n_axes,) of several blocks."""
    n, mean, square = (at[name][first].copy() for name in ("rest_n", "rest_mean", "rest_square"))
    for k in range(first + 1, end):
        more = at["rest_n"][k]
        with np.errstate(invalid="ignore", divide="ignore"):
            both = n + more
            apart = at["rest_mean"][k] - mean
            mean = np.where(more > 0, mean + apart * more / both, mean)
            square = np.where(
                more > 0, square + at["rest_square"][k] + apart * apart * n * more / both, square
            )
        n = both
    return n, mean, square
