"""Where the QP of the next window starts: at the last one's optimum, stage by stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mhe.sparse_qp.linearised_window import Lineariser, WindowStages
from mhe.sparse_qp.scaled_qp import ScaledQp
from models.arrays import Array


@dataclass(frozen=True, eq=False)
class LastOptimum:
    """Where a window ended, in no window's units.

    Parameters
    ----------
    times, x, w : (n,), (n, n_x), (n - 1, n_w) instants, states and noises
    of_states : (n, n_x) multipliers of the rows that lead to each state, the prior's first
    of_readings, of_constraints : (n, n_r), (n, n_c) multipliers of the other rows
    """

    times: Array
    x: Array
    w: Array
    of_states: Array
    of_readings: Array
    of_constraints: Array

    @classmethod
    def of(
        cls, lineariser: Lineariser, window: WindowStages, qp: ScaledQp, z: Array, y: Array
    ) -> LastOptimum:
        """Remember the optimum (z, y) of a window's QP."""
        delta, w = qp.deviations(z)
        rows, retract = qp.pattern.rows, lineariser.stage.retract
        return cls(
            window.times.copy(),
            np.array([retract(x, step) for x, step in zip(window.x, delta, strict=True)]),
            w,
            np.vstack([rows.view(y, "prior"), rows.view(y, "steps")]) / qp.state_scale,
            rows.view(y, "readings").copy(),
            qp.multipliers(y),
        )

    def start(
        self, lineariser: Lineariser, window: WindowStages, qp: ScaledQp
    ) -> tuple[Array, Array]:
        """Return (z, y) to start the QP of another window from.

        Stages that both have start where they ended, later ones are predicted from there.
        """
        (same,) = np.nonzero(self.times == window.times[0])
        dropped = int(same[0]) if same.size else len(self.times)
        n = len(self.times) - dropped
        if not np.array_equal(self.times[dropped:], window.times[:n]) or n == 0:
            return start_at_trajectory(window, qp)
        z, y = start_at_trajectory(window, qp)
        delta, w = qp.deviations(z)
        for k in range(n):
            delta[k] = lineariser.difference(self.x[dropped + k], window.x[k])
        for k in range(n - 1, len(delta) - 1):
            delta[k + 1] = qp.linear.F[k] @ delta[k] + qp.linear.b[k]
        w[: n - 1], w[n - 1 :] = self.w[dropped:], 0
        rows = qp.pattern.rows
        of_states = self.of_states[dropped:] * qp.state_scale
        rows.view(y, "prior")[:] = of_states[0]
        rows.view(y, "steps")[: n - 1] = of_states[1:]
        rows.view(y, "readings")[:n] = self.of_readings[dropped:]
        rows.view(y, "constraints")[:n] = self.of_constraints[dropped:] / qp.row_scale[:n]
        return qp.variables(delta, w), y


def start_at_trajectory(window: WindowStages, qp: ScaledQp) -> tuple[Array, Array]:
    """Return the trajectory itself as z, without multipliers."""
    return qp.variables(np.zeros(window.x.shape), window.w), np.zeros(qp.pattern.rows.size)
