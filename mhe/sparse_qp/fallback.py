"""Where passes do not settle on a set of active rows, OSQP solves the step.

The passes' own search for the set ends in theory; rounding, or a set larger than
`mhe.rules.MOST_ACTIVE`, may still end it early (`Status.SOLVER_FAILED`). The window then
goes to `mhe.sparse_qp.sequential_qp`, which is a hundred times slower and knows no deadline.
"""

from __future__ import annotations

import time

import numpy as np

from estimation.layout import Layout
from estimation.outputs import derived_outputs
from estimation.recording import Measurement
from estimation.status import Status
from mhe import constraint_rows
from mhe.config import RealTimeConfig
from mhe.look_back import told_stages
from mhe.sparse_qp.sequential_qp import SequentialQp
from mhe.trajectory import Trajectory
from mhe.window_memory import View
from models.arrays import Array
from models.state_space import StateSpaceModel


class Fallback:
    """A second try at windows that passes could not solve.

    Parameters
    ----------
    memory, result : layouts of an engine's state and of what its steps say
    """

    def __init__(
        self, model: StateSpaceModel, config: RealTimeConfig, memory: Layout, result: Layout
    ) -> None:
        self._model, self._config = model, config
        self._memory, self._result, self._derived = memory, result, derived_outputs(model)
        self._solver: SequentialQp | None = None
        self._is_possible = constraint_rows.count(model) > 0 and config.deadline_s is None

    def is_needed(self, status: Status) -> bool:
        """Return whether a step that ended so is to be tried again."""
        return self._is_possible and Status.SOLVER_FAILED in status

    def solve(self, given: Array, said: Array) -> tuple[Array, Array]:
        """Return the state and what the step says, solved again where OSQP can."""
        start = time.perf_counter()
        memory, result = given.copy(), said.copy()
        window = View.of(self._memory, memory)
        self._solver = self._solver or SequentialQp(self._model, self._config)
        measurements = tuple(map(self._measurement, window.times, window.y, window.present))
        guess = Trajectory(window.x.copy(), window.w.copy())
        found = self._solver.solve_window(window.prior, measurements, guess)
        if found.solution.status is not Status.SOLVED:
            return given, said
        window.x[:], window.w[:] = (
            found.solution.trajectory.states,
            found.solution.trajectory.noises,
        )
        window.active[:] = found.multipliers > 0
        window.moved[:] = np.inf
        window.newest.mean[:] = window.x[-1]
        view = self._result.view
        told = Status(int(view(result, "status"))) & ~Status.SOLVER_FAILED | Status.FELL_BACK
        view(result, "mean")[:] = window.x[-1]
        view(result, "status")[...] = told.value
        view(result, "cost")[...] = found.solution.cost
        view(result, "kkt")[...] = found.length
        view(result, "iterations")[...] += found.solution.iterations
        for i, (_, at) in enumerate(told_stages(self._config.lags, len(window.times))):
            view(result, "lagged_mean")[i] = window.x[at]
        self._derive(result, "")
        self._derive(result, "lagged_")
        view(result, "step_time_s")[...] += time.perf_counter() - start
        return memory, result

    def _derive(self, result: Array, prefix: str) -> None:
        """Derive again what people read, of the newest state or of all lags."""
        n_x, names = self._model.n_x, ("mean", "covariance", "derived", "derived_std")
        mean, P, derived, std = (self._result.view(result, prefix + name) for name in names)
        found = self._derived.values(mean.reshape(-1, n_x), P.reshape(-1, n_x, n_x))
        derived[...] = found[0].reshape(derived.shape)
        std[...] = found[1].reshape(std.shape)

    def _measurement(self, time_s: float, y: Array, present: Array) -> Measurement:
        """Return a stage's measurement: a reading that no used row needs counts as missing."""
        needed = self._model.row_needs[present > 0].any(axis=0)
        kept = np.concatenate([needed, np.ones(self._model.n_u, dtype=bool)])
        return Measurement(float(time_s), np.where(kept, y, np.nan))
