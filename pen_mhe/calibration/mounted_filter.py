"""The EKF of a pen that also says how its frames depend on how sensors are mounted.

The numbers θ of `pen_mhe.calibration.mounting` are states behind its own, known so well that no
reading moves them or the pen: their variance p is `KNOWN`² of what is plausible. Then their
covariance with the state carries dx̂/dθ along, and an update moves them by

    Δθ = p Zᵀ S⁻¹ v,     ΔP = -p² Zᵀ S⁻¹ Z,     Z = -dv/dθ,

which are p times a frame's score and p² times its information: one run says both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from estimation.collect import BATCH_STEPS
from models.arrays import Array
from models.gaussian import GaussianState
from models.pen import pen_model
from models.pen_body import pen_body
from models.pen_config import PenConfig
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.table import sensor_model
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from pen_mhe.calibration.mounting import OFFSET, MountedBody, Number, numbers_of, split
from pen_mhe.estimators import create_estimator
from pen_mhe.tuning.frames import camera_rows
from pen_mhe.tuning.known_states import known_behind, with_known_states
from pen_mhe.tuning.likelihood import log_densities

KNOWN = 1e-4
"""Of what is plausible: small against what all readings together tell, or they move the pen."""


@dataclass(frozen=True, eq=False)
class Told:
    """What rows of a run tell of k numbers.

    Parameters
    ----------
    time_s : (m,)
    log_density : (m,) of a frame given all that was before
    score : (m, k) its derivative, the mean of the frame moving only
    information : (m, k, k)
    """

    time_s: Array
    log_density: Array
    score: Array
    information: Array


class MountedFilter:
    """The EKF of a pen for any values of its numbers.

    Parameters
    ----------
    pen : what the numbers are changes of
    sensors : names of the pen's sensors
    """

    def __init__(self, pen: PenConfig, sensors: Sequence[str]) -> None:
        self.pen, self.sensors = pen, tuple(sensors)
        self.numbers: tuple[Number, ...] = numbers_of(pen, sensors)
        self.plausible_std = np.array([n.quantity.plausible_std for n in self.numbers])
        self.base = pen_model(pen, sensors, writing_area=False, rest=False)

    @cached_property
    def model(self) -> StateSpaceModel:
        """The model with its numbers behind its states."""
        base, n, k = self.base, self.base.n_x, len(self.numbers)
        x, w, dt = ca.SX.sym("x", n + k), ca.SX.sym("w", base.n_w), ca.SX.sym("dt")
        by = split(self.numbers, x[n:])
        freedom, spin = self.pen.degrees_of_freedom, self.pen.fixed_spin_rad
        captured = base.f(x[:n], ca.DM.zeros(base.n_w), by[OFFSET][0])
        rigid, seen = (pen_body(state, freedom, fixed_spin_rad=spin) for state in (x[:n], captured))
        body = MovingBody(
            MountedBody(rigid, seen, self.pen.level_rad, by),
            self.pen.gravity_m_s2,
            has_spin=freedom == 6,
        )

        def mounted(sensor: SensorModel) -> SensorModel:
            at = [base.state_names.index(name) for name in sensor.bias_states]
            return sensor_model(sensor.name, self.pen.sensors[sensor.name], body, x, x[at])

        return with_known_states(
            base,
            tuple(f"number_{i}" for i in range(k)),
            f=ca.Function("f", [x, w, dt], [ca.vertcat(base.f(x[:n], w, dt), x[n:])]),
            sensors=tuple(map(mounted, base.sensors)),
            prior=self._first(np.zeros(k)),
            moves=True,
        )

    def _first(self, values: Array) -> GaussianState:
        return known_behind(self.base.prior, values, KNOWN * self.plausible_std)

    @cached_property
    def _estimator(self) -> Any:
        return create_estimator("ekf", self.model)

    def told(
        self,
        values: Array,
        time_s: Array,
        y: Array,
        frames: NDArray[np.int_],
        *,
        rows: NDArray[np.bool_] | None = None,
    ) -> Told:
        """Return what frames tell with some values (k,) of the numbers.

        Parameters
        ----------
        time_s, y : (n,), (n, n_y) stacked readings; an instant with a frame has nothing else
        frames : (m,) which instants count
        rows : (n_r,) of the residual, whose density is told; None takes the camera's
        """
        n, p = self.base.n_x, (KNOWN * self.plausible_std) ** 2
        seen = camera_rows(self.base) if rows is None else rows
        state, kept = self._estimator.init(self._first(values)), []
        before = self._first(values)
        mean, P = before.mean[None, n:], before.covariance[None, n:, n:]
        with np.errstate(invalid="ignore"):  # of numbers with which it breaks down
            for start in range(0, len(time_s), BATCH_STEPS):
                some = slice(start, start + BATCH_STEPS)
                state, part = self._estimator.batch(state, time_s[some], y[some], covariances=True)
                mean = np.concatenate([mean[-1:], part.mean[:, n:]])
                P = np.concatenate([P[-1:], part.covariances.state[:, n:, n:]])
                at = frames[(frames >= start) & (frames < start + BATCH_STEPS)] - start
                v = part.innovation[at][:, seen]
                S = part.innovation_covariance[at][:, seen][:, :, seen]
                score, information = (mean[at + 1] - mean[at]) / p, P[at] - P[at + 1]
                times = part.time_s[at]
                kept.append((times, log_densities(v, S), score, information / np.outer(p, p)))
        return Told(*map(np.concatenate, zip(*kept, strict=True)))
