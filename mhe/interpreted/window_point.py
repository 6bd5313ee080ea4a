"""A window as the thing that a descent moves on."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from mhe.interpreted.deadline import Deadline
from mhe.interpreted.descent import LinearisedOptimum
from mhe.interpreted.pass_result import Pass
from mhe.interpreted.window_pass import WindowPass
from mhe.rules import WOUND
from mhe.window_memory import View
from models.arrays import Array


class WindowPoint:
    """Current point and candidate of a descent: see `mhe.interpreted.descent.Descending`."""

    def __init__(self, passes: WindowPass, window: View, deadline: Deadline) -> None:
        self._pass, self._window, self._deadline = passes, window, deadline
        self.found: Pass | None = None
        self.is_constrained = passes.n_c > 0
        [self.d] = passes.call["difference"](window.x[0], window.prior.mean)
        mu, self.distance = _prior_multiplier(window.prior.covariance, self.d)
        self.z = np.concatenate([mu, window.w.ravel()])
        self.readings, self.scales = passes.measure(window, window.x, window.w)
        self._weights = np.zeros(passes.n_c)
        self._violation = self._tried = passes.excess(window, window.x).sum(axis=0)
        self._candidate = self.z, self.d, window.x, self.scales

    @property
    def cost(self) -> float:
        """The window's cost at the point that it began with; infinite where it is no trajectory."""
        if not self._is_rolled_out:
            return np.inf
        return self.readings + self.distance / 2

    @property
    def _is_rolled_out(self) -> bool:
        """Whether the states follow from each other; see mhe/compiled/descent.c."""
        window, newest = self._window, len(self._window.times) - 1
        if window.apart:
            return False
        if not self.is_constrained or newest == 0:
            return True
        reached = self._pass.move(window, newest - 1, window.x[-2], window.w[-1])
        return bool((reached == window.x[-1]).all())

    @property
    def is_wound(self) -> bool:
        """Whether the first state is nearer to the prior than the deviation says."""
        [short] = self._pass.call["difference"](self._window.x[0], self._window.prior.mean)
        return bool((np.abs(self.d - short) > WOUND * np.maximum(1.0, np.abs(self.d))).any())

    def is_late(self) -> bool:
        """Whether the deadline leaves no time for another pass."""
        count = len(self._window.times)
        return self._deadline.affordable(count) < count

    def linearise(self) -> LinearisedOptimum:
        """Make a pass at the current point; return its optimum."""
        began, before = self._deadline.now(), self._window.active.copy()
        self.found = found = self._pass.run(self._window, self.d, self.scales)
        self._deadline.note_pass(len(self._window.times), began)
        multipliers = found.held.multipliers.reshape(-1, max(self._pass.n_c, 1))
        if found.held.active.any():
            self._weights = np.maximum(self._weights, 2 * multipliers.max(axis=0))
        step, P = found.mu - self.z[: len(found.mu)], self._window.prior.covariance
        return LinearisedOptimum(
            np.concatenate([found.mu, found.w.ravel()]),
            found.length + float(step @ P @ step),
            found.held.status,
            bool((before != self._window.active).any()),
        )

    def propose(self, z: Array) -> float:
        """Return the cost of a candidate, and keep it for `take`."""
        window, n_x = self._window, len(self.d)
        mu, w = z[:n_x], z[n_x:].reshape(self._window.w.shape)
        d = window.prior.covariance @ mu
        x = self._pass.roll_out(window, d, w)
        cost, scales = self._pass.measure(window, x, w)
        self._candidate = z, d, x, scales
        self._tried = self._pass.excess(window, x).sum(axis=0)
        return cost + float(mu @ d) / 2

    def penalty(self) -> float:
        """Return the weighed violation of the current point."""
        return float(self._weights @ self._violation)

    def penalty_tried(self) -> float:
        """Return the weighed violation of the candidate."""
        return float(self._weights @ self._tried)

    def take(self) -> None:
        """Make the candidate the current point."""
        self.z, self.d, self._window.x[:], self.scales = self._candidate
        self._window.w[:] = self.z[len(self.d) :].reshape(self._window.w.shape)
        self._window.apart[...] = 0
        self._violation = self._tried

    def inner(self, a: Array, b: Array) -> float:
        """Return the inner product of two points, whitened."""
        n_x, P = len(self.d), self._window.prior.covariance
        return float(a[:n_x] @ P @ b[:n_x] + a[n_x:] @ b[n_x:])


def _prior_multiplier(P: Array, d: Array) -> tuple[Array, float]:
    """Return μ of d = P̄ μ and dᵀ P̄⁻¹ d; zero and infinity where P̄ has no Cholesky factor."""
    try:
        L = np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return np.zeros(len(d)), np.inf
    z = solve_triangular(L, d, lower=True, check_finite=False)
    mu = solve_triangular(L, z, lower=True, trans=1, check_finite=False)
    return mu, float(z @ z)
