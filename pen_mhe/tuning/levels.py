"""A model whose levels are states that are known and never change: one compiled filter for all.

    x = (states, levels),   f(x, w, Δt) = (f_levels(states, w, Δt), levels),   residual / level ~ 1

Levels are standard deviations of residuals, densities of walks and the numbers of the chains. The
tangent space does not move them, so no gain and no derivative knows them: the filter is the one
of the model with these levels written in, while another choice is another first state, not
another compilation.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from estimation.collect import BATCH_STEPS
from estimation.covariances import Covariances
from estimation.estimate import EstimateHistory
from models.arrays import Array
from models.gaussian import GaussianState
from models.pen import pen_kinematics, pen_model
from models.pen_config import PenConfig
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from pen_mhe.tuning.known_states import known_behind, with_known_states
from pen_mhe.tuning.parameters import Parameter, parameters_of, with_values

KNOWN_STD = 1e-6
"""Of a level: a prior has to be positive definite, and this one has no effect."""

PROBE = 2.0
"""Factor by which a parameter is changed to see which rows it moves."""


@dataclass(frozen=True, eq=False)
class Levels:
    """The numbers of one choice of parameters: what a model has and `LevelFilter` needs."""

    model: StateSpaceModel
    motion: Array

    @property
    def rows(self) -> Array:
        """(n_r,) standard deviations of the stacked residual."""
        return self.model.noise_std

    @property
    def walks(self) -> Array:
        """(n_b,) densities of the biases' walks."""
        walks = [s.bias_walk for s in self.model.sensors for _ in s.bias_states]
        return np.array(walks, dtype=float)


def _groups(probes: Sequence[Array]) -> NDArray[np.int_]:
    """Return for each entry the first one that was equal to it in all probes."""
    columns = [tuple(column) for column in np.array(probes).T]
    return np.array([columns.index(column) for column in columns], dtype=np.int_)


class LevelFilter:
    """The EKF of a pen, for any values of its parameters.

    Parameters
    ----------
    pen : geometry, prior and everything that is not a parameter
    sensors : names of the pen's sensors
    writing_area : see `models.pen.pen_model`; a pen's sensor of rest takes no part, as it would
        judge by the levels themselves
    """

    def __init__(
        self, pen: PenConfig, sensors: Sequence[str], *, writing_area: bool = True
    ) -> None:
        self.pen, self.sensors, self.writing_area = pen, tuple(sensors), writing_area
        self.parameters = parameters_of(pen, sensors)
        self._chain = tuple(p for p in self.parameters if p.role == "chain")
        self.base = self._levels(pen)
        self._n = self.base.model.n_x
        self._last: tuple[PenConfig, Levels] | None = None

    @cached_property
    def _probes(self) -> list[Levels]:
        """The levels as they are, and with one noise or walk changed at a time."""
        changed = [
            with_values(self.pen, {p: PROBE * p.start(self.pen)})
            for p in self.parameters
            if p.role != "chain"
        ]
        return [self.base, *map(self._levels, changed)]

    @cached_property
    def _row_group(self) -> NDArray[np.int_]:
        """(n_r,) the first row that has the same level, whatever the parameters."""
        return _groups([levels.rows for levels in self._probes])

    @cached_property
    def _walk_group(self) -> NDArray[np.int_]:
        """(n_b,) likewise of walks."""
        return _groups([levels.walks for levels in self._probes])

    def _levels(self, pen: PenConfig) -> Levels:
        model = pen_model(pen, self.sensors, writing_area=self.writing_area, rest=False)
        return Levels(model, np.array([p.value(pen) for p in self._chain]))

    def _level_values(self, levels: Levels) -> Array:
        """Return the states that hold levels (k,)."""
        rows, walks = np.unique(self._row_group), np.unique(self._walk_group)
        return np.concatenate([levels.motion, levels.walks[walks], levels.rows[rows]])

    @cached_property
    def model(self) -> StateSpaceModel:
        """The model with its levels as states behind its own."""
        base, n = self.base.model, self._n
        motion, walks = len(self._chain), np.unique(self._walk_group)
        rows = np.unique(self._row_group)
        k = motion + len(walks) + len(rows)
        x, w, dt = ca.SX.sym("x", n + k), ca.SX.sym("w", base.n_w), ca.SX.sym("dt")
        walk = x[n + motion + np.searchsorted(walks, self._walk_group)]
        row = x[n + motion + len(walks) + np.searchsorted(rows, self._row_group)]
        moved = self._moved(x[:n], w, dt, dict(zip(self._chain, ca.vertsplit(x)[n:], strict=False)))
        biases = n - walk.numel()
        moved[biases:] = x[biases:n] + walk * ca.sqrt(dt) * w[biases:]
        return with_known_states(
            base,
            tuple(f"level_{i}" for i in range(k)),
            f=ca.Function("f", [x, w, dt], [ca.vertcat(moved, x[n:])]),
            sensors=self._in_levels(x, row),
            prior=self._first(self.base),
        )

    def _moved(self, x: ca.SX, w: ca.SX, dt: ca.SX, motion: Mapping[Parameter, Any]) -> ca.SX:
        """Return the states (n,) after a step whose chains have symbols for their numbers."""
        symbolic = with_values(self.pen, motion)
        # Its prior is not used: the camera's is made of numbers only.
        kinematics, _ = pen_kinematics(symbolic, has_camera=True)
        n = kinematics.x.numel()
        return ca.vertcat(kinematics.step(x[:n], w[:n], dt), x[n:])

    def _in_levels(self, x: ca.SX, row: ca.SX) -> tuple[SensorModel, ...]:
        """Return the sensors, their residuals in units of their levels."""
        scaled, start = [], 0
        for sensor in self.base.model.sensors:
            y = ca.SX.sym("y", sensor.n_y)
            level = row[start : start + sensor.n_r]
            residual = sensor.residual(y, x[: self._n]) / level
            scaled.append(
                dataclasses.replace(
                    sensor,
                    h=ca.Function(f"h_{sensor.name}", [x], [sensor.h(x[: self._n])]),
                    residual=ca.Function(f"residual_{sensor.name}", [y, x], [residual]),
                    noise_std=np.ones(sensor.n_r),
                )
            )
            start += sensor.n_r
        return tuple(scaled)

    def _first(self, levels: Levels) -> GaussianState:
        """Return the prior of a choice, its levels behind its states."""
        values = self._level_values(levels)
        known = np.full(len(values), KNOWN_STD)
        return known_behind(levels.model.prior, values, known)

    @cached_property
    def _estimator(self) -> Any:
        return create_estimator("ekf", self.model)

    def history(
        self, pen: PenConfig, time_s: Array, y: Array, *, covariances: bool = False
    ) -> EstimateHistory:
        """Return what ``ekf`` says of stacked readings, with the parameters of a pen.

        Parameters
        ----------
        pen : this filter's, but for values of its parameters
        time_s, y : (n,), (n, n_y)
        covariances : keep those of the innovations
        """
        if self._last is None or self._last[0] is not pen:
            self._last = (pen, self._levels(pen))
        levels = self._last[1]
        estimator, row = self._estimator, levels.rows
        state, parts = estimator.init(self._first(levels)), []
        with np.errstate(invalid="ignore"):  # of a choice that breaks down
            for start in range(0, len(time_s), BATCH_STEPS):
                some = slice(start, start + BATCH_STEPS)
                state, part = estimator.batch(state, time_s[some], y[some], covariances=covariances)
                parts.append(_in_units(part, row))
        return EstimateHistory.joined(parts)


def _in_units(history: EstimateHistory, row: Array) -> EstimateHistory:
    """Return a history whose innovations are in their units, not in levels (n_r,)."""
    kept = history.covariances
    return dataclasses.replace(
        history,
        innovation=history.innovation * row,
        innovation_std=history.innovation_std * row,
        # Those of the states are many and not asked for.
        covariances=kept
        and Covariances(kept.state[:, :0, :0], kept.innovation * np.outer(row, row)),
    )
