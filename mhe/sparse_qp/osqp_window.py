"""The linearised window problem with its constraint rows, as a sparse QP for OSQP.

Unknown are the whitened prior u, deviations δ_k = S δ̂_k from a trajectory (x̃, w̃), unit
noises ω_k and whitened residuals r_k. S holds standard deviations, σ those of the readings,
D the scales of the noises; all else is that of `estimation.kalman_stage`.

    min  ½‖u‖² + ½ Σ‖ω_k‖² + ½ Σ‖r_k‖²
    s.t. δ̂_0 - S⁻¹ L̄ u                       = -S⁻¹ d                     x_0 = x̄ ⊞ d ⊞ δ_0
         δ̂_{k+1} - S⁻¹ F S δ̂_k - S⁻¹ G D ω_k = S⁻¹ (f(x̃_k, w̃_k) ⊟ x̃_{k+1} - G w̃_k)
         r_k + σ⁻¹ H S δ̂_k                   = σ⁻¹ residual(y_k, x̃_k)
         ρ Cᵀ S δ̂_k                          ≤ -ρ g(x̃_k)                  where demanded

(On a manifold L̄ and d are carried to the tangent space at x_0, `mhe.stage_functions`.)

Neither P̄ nor the noise's covariance is inverted, and the Hessian is a constant: with
readings as rows, not as HᵀH, no condition number is squared. (With HᵀH OSQP's optimum of a pen
with an accelerometer was 1e-3 standard deviations off, with rows it is exact to 1e-12.)

OSQP's iterations find about which rows hold. Its polish brings the last digits, or
`mhe.sparse_qp.crossover` where rows are too stiff for that.

An independent reference of the compiled pass (`mhe.realtime`), and what is left where its
active-set method gives up.

References
----------
Stellato, Banjac, Goulart, Bemporad, Boyd (2020), OSQP: an operator splitting solver for
quadratic programs, Mathematical Programming Computation 12.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.status import Status
from mhe.constraint_rows import count
from mhe.sparse_qp.crossover import crossed_over
from mhe.sparse_qp.linearised_window import Lineariser, WindowStages
from mhe.sparse_qp.pattern import QpPattern
from mhe.sparse_qp.scaled_qp import ScaledQp
from mhe.sparse_qp.warm_start import LastOptimum, start_at_trajectory
from mhe.window_memory import Scales
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel

SETTINGS: Mapping[str, Any] = MappingProxyType(
    {
        "verbose": False,
        "max_iter": 4000,
        "check_termination": 5,
        "eps_prim_inf": 1e-9,
        "eps_dual_inf": 1e-9,
        "adaptive_rho_interval": 50,  # by count, not by time: the same every time
        "polishing": True,
        "delta": 1e-9,
        "polish_refine_iter": 10,
    }
)
"""Of OSQP."""

EPSILONS = (1e-3, 1e-5, 1e-7, 1e-9)
"""Where OSQP's iterations end, one after the other, until the optimum is accurate: mostly at the
first, polished. Where OSQP's own polish fails, `mhe.sparse_qp.crossover` looks for the rows that
hold."""

ACCURATE = 1e-10
"""Largest residual of the optimality conditions, everything in standard deviations."""

UNLIMITED = 1e30
"""OSQP's infinity: a row that has to be beyond it is a contradiction to it, and an exception."""

SCALE_KEPT = 4.0
"""While no standard deviation has changed by more than this factor, S stays."""


@dataclass(frozen=True, eq=False)
class QpSolution:
    """Optimum of a linearised window.

    Parameters
    ----------
    d : (n, n_x) deviations δ from the trajectory
    w : (n - 1, n_w) noises themselves
    multipliers : (n, n_c) of the constraint rows, not negative
    length : of the step from the trajectory, in the unit of the whitened problem
    newest : (n_x, n_x) covariance of the newest state, without constraints
    status : of the solver
    iterations : of the solver
    kept_factors : whether only vectors differed from the window before
    """

    d: Array
    w: Array
    multipliers: Array
    length: float
    newest: Array
    status: Status
    iterations: int
    kept_factors: bool

    @property
    def solved(self) -> bool:
        """Whether it is the optimum."""
        return self.status is Status.SOLVED


class OsqpWindow:
    """Windows of one model and length, in one OSQP that is set up once.

    A window starts from the last one's optimum, stage by stage. Where only vectors
    differ from it (the same slopes, as in a linear model with a steady prior), OSQP keeps
    its factorisation.

    Parameters
    ----------
    model : with or without constraints
    n_stages : of every window
    """

    def __init__(self, model: StateSpaceModel, n_stages: int) -> None:
        import osqp  # 0.2 s, for those who need it

        self.lineariser, self.n_stages = Lineariser(model), n_stages
        self._names = {status.value: status.name for status in osqp.SolverStatus}
        self._solver, self._pattern = osqp.OSQP(), QpPattern(self.lineariser.stage, n_stages)
        self._values: Array | None = None
        self._scale = np.full(model.n_x, np.nan)
        self._last: LastOptimum | None = None

    def forget(self) -> None:
        """Start the next window from its own trajectory, not from the last optimum."""
        self._last = None

    def run(
        self, window: WindowStages, d: Array, scales: Scales, demanded: NDArray[np.bool_]
    ) -> QpSolution:
        """Return the linearised window's optimum; see `mhe.interpreted.window_pass.WindowPass.run`.

        Parameters
        ----------
        window : with its trajectory (x̃, w̃)
        d : (n_x,) deviation of x̃_0 from the prior's mean
        scales : of rows and noises
        demanded : (n, n_c) constraint rows that hold

        Raises
        ------
        InputError
            If the window has another number of stages.
        """
        if len(window.times) != self.n_stages:
            raise InputError(
                f"a window of {len(window.times)} stages, expected {self.n_stages}: "
                "an OsqpWindow is made for one length"
            )
        prior, d = self.lineariser.carried(window.prior, d, window.x[0])
        linear = self.lineariser(window, scales, prior=prior)
        L = factor_of(prior.covariance)
        self._rescale(linear.newest)
        qp = ScaledQp(self._pattern, linear, L, d, scales.noises, self._scale)
        lower, upper = limits = qp.limits(demanded)
        if not qp.is_finite or (lower > UNLIMITED).any() or (upper < -UNLIMITED).any():
            return self._unsolved(window, linear.newest, Status.NOT_FINITE, 0)
        kept = self._hand_over(qp, *limits)
        here = start_at_trajectory(window, qp)
        start = here if self._last is None else self._last.start(self.lineariser, window, qp)
        z, y, status, iterations = self._solve(qp, limits, start)
        if status is not Status.SOLVED:
            return self._unsolved(window, linear.newest, status, iterations)
        self._last = LastOptimum.of(self.lineariser, window, qp, z, y)
        multipliers = np.maximum(qp.multipliers(y), 0)
        length = qp.length(z, here[0])
        return QpSolution(
            *qp.deviations(z), multipliers, length, linear.newest, status, iterations, kept
        )

    def _solve(
        self, qp: ScaledQp, limits: tuple[Array, Array], start: tuple[Array, Array]
    ) -> tuple[Array, Array, Status, int]:
        """Return z, y, status and OSQP's iterations."""
        self._solver.warm_start(*start)
        iterations, status = 0, Status.SOLVER_FAILED
        for epsilon in EPSILONS:
            self._solver.update_settings(eps_abs=epsilon, eps_rel=epsilon)
            found = self._solver.solve(raise_error=False)
            iterations += int(found.info.iter)
            name = self._names[found.info.status_val]
            residual = max(found.info.prim_res, found.info.dual_res)
            if name == "OSQP_SOLVED" and residual <= ACCURATE:
                return found.x, found.y, Status.SOLVED, iterations
            if name == "OSQP_PRIMAL_INFEASIBLE":
                status = Status.INFEASIBLE
                break
            A = self._pattern.matrix(qp.values)
            exact = crossed_over(self._pattern.hessian, A, *limits, found.y > 0, ACCURATE)
            if exact is not None:
                return *exact, Status.SOLVED, iterations
        return *start, status, iterations

    def _unsolved(
        self, window: WindowStages, newest: Array, status: Status, iterations: int
    ) -> QpSolution:
        """Return the trajectory unmoved, and start afresh next time."""
        self.forget()
        multipliers = np.zeros((self.n_stages, count(self.lineariser.model)))
        nothing = np.zeros(window.x.shape)
        return QpSolution(
            nothing, window.w.copy(), multipliers, np.nan, newest, status, iterations, False
        )

    def _rescale(self, newest: Array) -> None:
        variance = np.diag(newest)
        std = np.sqrt(np.where(np.isfinite(variance) & (variance > 0), variance, 1.0))
        near = (std < SCALE_KEPT * self._scale) & (self._scale < SCALE_KEPT * std)
        if not near.all():
            self._scale = std

    def _hand_over(self, qp: ScaledQp, lower: Array, upper: Array) -> bool:
        """Give OSQP the numbers; return whether its factorisation stays."""
        before, self._values = self._values, qp.values
        if before is None:
            P, A = self._pattern.hessian, self._pattern.matrix(qp.values)
            self._solver.setup(P, np.zeros(P.shape[0]), A, lower, upper, **SETTINGS)
            return False
        if np.array_equal(before, qp.values):
            self._solver.update(l=lower, u=upper)
            return True
        self._solver.update(Ax=qp.values, l=lower, u=upper)
        return False


def factor_of(P: Array) -> Array:
    """Return the Cholesky factor of P, NaN where there is none."""
    try:
        return np.asarray(np.linalg.cholesky(P))
    except np.linalg.LinAlgError:
        return np.full(P.shape, np.nan)
