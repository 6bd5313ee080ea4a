"""How a window is solved in Python: one pass, or passes to convergence, from another start too."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from estimation.kalman_stage import Update
from estimation.lagged import LaggedState
from estimation.status import Status
from mhe.config import RealTimeConfig
from mhe.interpreted.deadline import Deadline
from mhe.interpreted.descent import descend
from mhe.interpreted.pass_result import Pass
from mhe.interpreted.window_pass import WindowPass
from mhe.interpreted.window_point import WindowPoint
from mhe.look_back import told_stages
from mhe.reuse import SETTLED, reuse_threshold
from mhe.rules import MOST_TURNS
from mhe.second_start import cost_limits, is_better, started_beside
from mhe.window_memory import Scales, View
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


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


class WindowMinimiser:
    """Solves windows as mhe/compiled/one_pass.c, descent.c and second_start.c do.

    Parameters
    ----------
    passes : over the window
    deadline : that passes are noted by
    """

    def __init__(
        self, model: StateSpaceModel, config: RealTimeConfig, passes: WindowPass, deadline: Deadline
    ) -> None:
        self._model, self._config, self._scheme = model, config, config.scheme
        self._pass, self._deadline = passes, deadline
        self._reuse = reuse_threshold(model, config)
        self._cost_limits = cost_limits(config.horizon + 1, model.n_r)

    def solve(self, window: View) -> Solved:
        """Make one pass or converge, as the scheme has it; say where a minimum is improbable."""
        made = self.converge_twice if self._scheme.converges else self.one_pass
        return self.judge(window, made(window))

    def one_pass(self, window: View) -> Solved:
        """Make the linearised window's optimum the trajectory."""
        began = self._deadline.now()
        cost, scales = 0.0, Scales(window.present, np.ones(window.w.shape))
        if self._config.has_losses:
            cost, scales = self._pass.measure(window, window.x, window.w)
        at = window.x_lin, window.w_lin
        settled = SETTLED * self._reuse
        found = self._pass.run(window, -window.prior_deviation, scales, *at, settled)
        if not (np.isfinite(found.length) and np.isfinite(cost)):
            return Solved(found.newest, found.newest.state, Status.NOT_FINITE, 1)
        window.w[:] = found.w
        renewed = slice(found.oldest, None)
        for k in range(len(window.times))[renewed]:
            window.x[k] = self._pass.stage.retract(window.x_lin[k], found.d[k])
        lagged = self._look_back_from(window, found)
        self._deadline.note_pass(len(window.times) - int(window.stayed), began)
        if self._reuse > 0:
            for k, by in list(enumerate(_moved(found)))[renewed]:
                window.moved[k] = self._judged(window, k, by, found.expected[k])
        kkt = max(np.sqrt(found.length), self._largest_excess(window, found.row_std))
        ended = found.held.status, 1, found.cost, kkt
        return Solved(found.newest, found.newest.state, *ended, lagged)

    def _look_back_from(self, window: View, found: Pass) -> tuple[LaggedState, ...]:
        """Look back behind a pass; the window's own states are older before its `oldest`."""
        states = window.x.copy()
        for _, at in told_stages(self._config.lags, len(states)):
            if at < found.oldest:
                states[at] = self._pass.stage.retract(window.x_lin[at], found.d[at])
        return self._pass.look_back(window, states, found)

    def _judged(self, window: View, k: int, by: float, expected: Array) -> float:
        """Return how far a stage is from its linearisation point, squared, as one_pass.c does."""
        if by > self._reuse**2:
            return by
        [off] = self._pass.call["judge"](window.x[k], window.y[k], window.present[k], expected)
        return max(by, float(off[0]) ** 2)

    def _largest_excess(self, window: View, row_std: Array) -> float:
        """Return what the trajectory exceeds a row by at most, in standard deviations."""
        excess = self._pass.excess(window, window.x)
        exceeded = excess > 0
        return float((excess[exceeded] / row_std[exceeded]).max(initial=0.0))

    def judge(self, window: View, solved: Solved) -> Solved:
        """Say so where chance can hardly explain the cost of a minimum."""
        is_full = len(window.times) > self._config.horizon
        judged = solved.status is Status.SOLVED and (self._scheme.converges or is_full)
        if judged and self._is_improbable(window, solved.cost):
            return replace(solved, status=Status.IMPROBABLE)
        return solved

    def _is_improbable(self, window: View, cost: float) -> bool:
        return bool(cost > self._cost_limits[np.count_nonzero(window.present)])

    def _is_doubtful(self, window: View, first: Solved) -> bool:
        if first.status:
            return Status.SOLVER_FAILED in first.status
        if window.wait > 0:
            window.wait[...] -= 1
            return False
        return self._is_improbable(window, first.cost) or bool(window.active.any())

    def converge_twice(self, window: View) -> Solved:
        """Converge, and where the minimum is doubtful once more: mhe/compiled/second_start.c."""
        first, count = self._converge(window), len(window.times)
        if not self._is_doubtful(window, first) or self._deadline.affordable(count) < count:
            return first
        kept = [(block, block.copy()) for block in (window.x, window.w, window.active)]
        window.x[0], window.w[:] = started_beside(self._model, window.prior), 0
        for k in range(len(window.w)):
            window.x[k + 1] = self._pass.move(window, k, window.x[k], window.w[k])
        window.active[:] = 0
        again = self._converge(window, first.iterations)
        ends = again.status, again.cost, first.status, first.cost
        if is_better(*ends, is_free=self._pass.n_c == 0):
            return again
        for block, values in kept:
            block[:] = values
        if first.status is Status.SOLVED and count > self._config.horizon:
            window.wait[...] = self._config.horizon
        return replace(first, iterations=again.iterations)

    def _converge(self, window: View, passes: int = 0) -> Solved:
        """Passes to convergence, counted on from those that were made."""
        point = WindowPoint(self._pass, window, self._deadline)
        if not np.isfinite(point.readings):
            found = self._pass.run(window, point.d, point.scales)
            return Solved(found.newest, found.newest.state, Status.NOT_FINITE, passes + 1)
        end = descend(point, point.z, point.cost, self._scheme, passes)
        for _ in range(MOST_TURNS):
            if end.status is not Status.SOLVED or not point.is_wound:
                break
            again = WindowPoint(self._pass, window, self._deadline)
            end = descend(again, again.z, again.cost, self._scheme, end.iterations)
            point = again
        assert point.found is not None
        found = point.found
        kkt = max(end.kkt, self._largest_excess(window, found.row_std))
        ended = end.status, end.iterations, end.cost, kkt
        lagged = self._pass.look_back(window, window.x, found)
        return Solved(found.newest, found.newest.state, *ended, lagged)


def _moved(found: Pass) -> Array:
    """Return the largest squared deviation (n,) of the stages, in variances."""
    variances = np.diagonal(found.covariances, axis1=1, axis2=2)
    squares = found.d**2
    ratios = np.zeros(squares.shape)
    np.divide(squares, variances, out=ratios, where=squares > 0)
    largest: Array = ratios.max(axis=1)
    return largest
