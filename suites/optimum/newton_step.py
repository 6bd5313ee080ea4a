"""How far a solution of a window is from a stationary point, by one exact Newton step.

With J the Jacobian of the window's residual (`mhe.reference.window`), A that of its constraints g
and H the Hessian of the Lagrangian f + λᵀg,

    [JᵀJ  Aᵀ] [·]     [∇f]      [H  Aᵀ] [p]     [∇f]
    [A     0] [λ] = - [g ],     [A   0] [·] = - [g ]

p is the Newton step, ‖J p‖ its length. A Gauss-Newton step would not do: where residuals
are large it is as much as a hundred times shorter or longer than the way that is left. No
solver's own statement enters. Where states have bounds the step is that of the quadratic problem
with those bounds: the states that they hold are found on the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from estimation.recording import Measurement
from mhe.config import WindowConfig
from mhe.reference.window import WindowProblem
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

AT_BOUND = 1e-9
"""How near to a bound a state stands there, standard deviations: IPOPT's barrier keeps it off."""
CHANGES = 50
"""How often the held components may change; a few do for windows that have a minimum."""


@dataclass(frozen=True, eq=False)
class NewtonStep:
    """What a Newton step would still change.

    Parameters
    ----------
    length : of the whole step, in the unit of the whitened problem: no state of the window
        would move by more of its posterior standard deviations
    gauss_newton_length : the same of a Gauss-Newton step
    newest : (n_x,) what it would add to the newest state
    """

    length: float
    gauss_newton_length: float
    newest: Array


class NewtonCheck:
    """Newton steps of windows with N + 1 stages of a model without inequalities.

    Raises
    ------
    InputError
        If the model has inequalities, or bounds on states that do not add.
    """

    def __init__(self, model: StateSpaceModel, config: WindowConfig) -> None:
        self.model, self._problem = model, WindowProblem.build(model, config)
        x, p, f, g = (self._problem.nlp[name] for name in ("x", "p", "f", "g"))
        if g.numel() != model.n_x * (config.horizon + 1):
            raise InputError(
                f"model {model.name} has inequalities, or bounds on states that do not add, "
                "expected one without"
            )
        multipliers = ca.SX.sym("multipliers", g.numel())
        H, _ = ca.hessian(f + ca.dot(multipliers, g), x)
        # Called once or twice a window: looking for common parts would take longer.
        self._derivatives = ca.Function(
            "derivatives", [x, p], [ca.gradient(f, x), g, ca.jacobian(g, x)]
        )
        self._hessian = ca.Function("hessian", [x, p, multipliers], [H])

    def step(
        self,
        prior: GaussianState,
        measurements: tuple[Measurement, ...],
        trajectory: Trajectory,
        scale: Array,
    ) -> NewtonStep:
        """Return the Newton step from a trajectory.

        Parameters
        ----------
        prior, measurements : the window, N + 1 stages or fewer
        scale : (n_x,) unit that every state is counted in, about a standard deviation
        """
        problem = self._problem
        parameters = problem.parameters(prior, measurements, trajectory.states, scale)
        variables = problem.pack(prior, trajectory)
        upper = sp.csc_array(problem.gauss_newton(variables, parameters, 1.0, 0.0).sparse())
        JtJ = upper + sp.triu(upper, 1).T
        gradient, gaps, slopes = self._derivatives(variables, parameters)
        right = -np.concatenate([gradient.full().ravel(), gaps.full().ravel()])
        A = sp.csc_array(slopes.sparse())
        limits = problem.limits(measurements, trajectory.states, scale)
        bounds = limits["lbx"], limits["ubx"]
        gauss_newton, multipliers, held = _solved(JtJ, A, right, bounds, at_bound(*bounds))
        H = sp.csc_array(self._hessian(variables, parameters, multipliers).sparse())
        newton, _, _ = _solved(H, A, right, bounds, held)
        return NewtonStep(
            float(np.sqrt(newton @ (JtJ @ newton))),
            float(np.sqrt(gauss_newton @ (JtJ @ gauss_newton))),
            scale * newton[-self.model.n_x :],
        )


def at_bound(low: Array, high: Array) -> NDArray[np.int_]:
    """Return -1 where a step (n,) stands at its lower bound, 1 at its upper one, else 0."""
    return np.where(low > -AT_BOUND, -1, np.where(high < AT_BOUND, 1, 0))


def _solved(
    H: sp.csc_array,
    A: sp.csc_array,
    right: Array,
    bounds: tuple[Array, Array],
    held: NDArray[np.int_],
) -> tuple[Array, Array, NDArray[np.int_]]:
    """Return the step within its bounds, the multipliers of the constraints, and what is held.

    Components are let go, and others held, until none is beyond a bound and none is held that
    wants inside; a step that this does not settle is NaN. H may be indefinite where nothing is
    held: it begins with what the Gauss-Newton step, whose Hessian is not, ends with.

    Parameters
    ----------
    held : what is held first, see `at_bound`
    """
    n, (low, high) = H.shape[0], bounds
    step, multipliers = np.full(n, np.nan), np.zeros(len(right) - n)
    for _ in range(CHANGES):
        known = np.where(held < 0, low, high)
        step, multipliers = _held_step(H, A, right, np.where(held, known, np.nan))
        pull = H @ step + A.T @ multipliers - right[:n]  # of the bounds: up where low holds
        stays = np.where(held < 0, pull > 0, pull < 0) & (held != 0)
        beyond = np.where(step < low, -1, np.where(step > high, 1, 0))
        changed = np.where(held != 0, held * stays, beyond)
        if (changed == held).all():
            return step, multipliers, held
        held = changed
    return np.full(n, np.nan), multipliers, held


def _held_step(H: sp.csc_array, A: sp.csc_array, right: Array, known: Array) -> tuple[Array, Array]:
    """Return step and multipliers where some components (n,) are known, the others NaN.

    Without one, where the system is singular, they are NaN.
    """
    n, free = H.shape[0], np.isnan(known)
    step = np.where(free, 0.0, known)
    shift = np.concatenate([H @ step, A @ step])
    inside = H[:, free][free], A[:, free]
    rows: list[list[sp.sparray | None]] = [[inside[0], inside[1].T], [inside[1], None]]
    wanted = (right - shift)[np.concatenate([free, np.ones(len(right) - n, dtype=bool)])]
    try:
        found = splu(sp.block_array(rows, format="csc")).solve(wanted)
    except RuntimeError:  # singular: there is no such step
        found = np.full(len(wanted), np.nan)
    step[free] = found[: free.sum()]
    return step, found[free.sum() :]
