"""How far a solution of a window is from a stationary point, by one exact Newton step.

With J the Jacobian of the window's residual (`mhe.reference.window`), A that of its constraints g
and H the Hessian of the Lagrangian f + λᵀg,

    [JᵀJ  Aᵀ] [·]     [∇f]      [H  Aᵀ] [p]     [∇f]
    [A     0] [λ] = - [g ],     [A   0] [·] = - [g ]

p is the Newton step, ‖J p‖ its length. A Gauss-Newton step would not do: where residuals
are large it is as much as a hundred times shorter or longer than the way that is left. No
solver's own statement enters.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from estimation.recording import Measurement
from mhe.config import WindowConfig
from mhe.reference.window import WindowProblem
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


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
    """Newton steps of windows with N + 1 stages of a model without bounds and inequalities.

    Raises
    ------
    InputError
        If the model has bounds or inequalities.
    """

    def __init__(self, model: StateSpaceModel, config: WindowConfig) -> None:
        self.model, self._problem = model, WindowProblem.build(model, config)
        x, p, f, g = (self._problem.nlp[name] for name in ("x", "p", "f", "g"))
        if g.numel() != model.n_x * (config.horizon + 1):
            raise InputError(
                f"model {model.name} has bounds or inequalities, expected one without: "
                "a Newton step does not know which of them hold it"
            )
        multipliers = ca.SX.sym("multipliers", g.numel())
        H, _ = ca.hessian(f + ca.dot(multipliers, g), x)
        self._derivatives = ca.Function(
            "derivatives", [x, p], [ca.gradient(f, x), g, ca.jacobian(g, x)], {"cse": True}
        )
        self._hessian = ca.Function("hessian", [x, p, multipliers], [H], {"cse": True})

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
        gauss_newton, multipliers = _solved(JtJ, A, right)
        H = sp.csc_array(self._hessian(variables, parameters, multipliers).sparse())
        newton, _ = _solved(H, A, right)
        return NewtonStep(
            float(np.sqrt(newton @ (JtJ @ newton))),
            float(np.sqrt(gauss_newton @ (JtJ @ gauss_newton))),
            scale * newton[-self.model.n_x :],
        )


def _solved(H: sp.csc_array, A: sp.csc_array, right: Array) -> tuple[Array, Array]:
    """Return step and multipliers."""
    n = H.shape[0]
    rows: list[list[sp.sparray | None]] = [[H, A.T], [A, None]]
    found = splu(sp.block_array(rows, format="csc")).solve(right)
    return found[:n], found[n:]
