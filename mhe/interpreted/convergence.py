"""Passes to convergence, and once more from another start where the minimum is doubtful."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from estimation.kalman_stage import Update
from estimation.lagged import LaggedState
from estimation.status import Status
from mhe.config import RealTimeConfig
from mhe.interpreted.deadline import Deadline
from mhe.interpreted.descent import descend
from mhe.interpreted.window_pass import WindowPass
from mhe.interpreted.window_point import WindowPoint
from mhe.rules import MOST_TURNS
from mhe.second_start import cost_limits, is_better, started_beside
from mhe.window_memory import View
from models.gaussian import GaussianState


@dataclass(frozen=True, eq=False)
class Solved:
    """How solving a window ended.

    Parameters
    ----------
    newest : update of the newest stage; None where there was no pass
    known : of the newest state, for its covariance
    kkt : see `estimation.estimate.Estimate.kkt_residual`
    lagged : of earlier stages, see `mhe.look_back`
    """

    newest: Update | None
    known: GaussianState
    status: Status
    iterations: int = 0
    cost: float = np.nan
    kkt: float = np.nan
    lagged: tuple[LaggedState, ...] = ()


class Convergence:
    """Solves windows; the equations of mhe/compiled/descent.c and second_start.c.

    Parameters
    ----------
    passes : over the window, with the functions of its stages
    """

    def __init__(self, passes: WindowPass, config: RealTimeConfig, deadline: Deadline) -> None:
        self._pass, self._config, self._deadline = passes, config, deadline
        self._cost_limits = cost_limits(config.horizon + 1, passes.stage.model.n_r)

    def is_improbable(self, window: View, cost: float) -> bool:
        """Return whether chance can hardly explain a cost; see `mhe.second_start`."""
        return bool(cost > self._cost_limits[np.count_nonzero(window.present)])

    def _is_doubtful(self, window: View, first: Solved) -> bool:
        if first.status:
            return Status.SOLVER_FAILED in first.status
        if window.wait > 0:
            window.wait[...] -= 1
            return False
        return self.is_improbable(window, first.cost) or bool(window.active.any())

    def solve(self, window: View) -> Solved:
        """Converge, and where the minimum is doubtful once more: mhe/compiled/second_start.c."""
        first, count = self._converge(window), len(window.times)
        if not self._is_doubtful(window, first) or self._deadline.affordable(count) < count:
            return first
        parts = window.x, window.w, window.active, window.apart
        kept = [(block, block.copy()) for block in parts]
        window.w[:], window.active[:], window.apart[...] = 0, 0, 0
        beside = started_beside(self._pass.stage.model, window.prior)
        window.x[:] = self._pass.states_from(window, beside, window.w)
        again = self._converge(window, first.iterations)
        ends = again.status, again.cost, first.status, first.cost
        if is_better(*ends, is_free=self._pass.n_c == 0):
            return again
        for block, values in kept:
            block[...] = values
        if first.status is Status.SOLVED and count > self._config.horizon:
            window.wait[...] = self._config.horizon
        return replace(first, iterations=again.iterations)

    def _converge(self, window: View, passes: int = 0) -> Solved:
        """Passes to convergence, counted on from those that were made."""
        point = WindowPoint(self._pass, window, self._deadline)
        if not np.isfinite(point.readings):
            found = self._pass.run(window, point.d, point.scales)
            return Solved(found.newest, found.newest.state, Status.NOT_FINITE, passes + 1)
        end = descend(point, point.z, point.cost, self._config.scheme, passes)
        for _ in range(MOST_TURNS):
            if end.status is not Status.SOLVED or not point.is_wound:
                break
            again = WindowPoint(self._pass, window, self._deadline)
            end = descend(again, again.z, again.cost, self._config.scheme, end.iterations)
            point = again
        assert point.found is not None
        found = point.found
        kkt = max(end.kkt, self._pass.largest_excess(window, found.row_std))
        ended = end.status, end.iterations, end.cost, kkt
        lagged = self._pass.look_back(window, window.x, found)
        return Solved(found.newest, found.newest.state, *ended, lagged)
