"""A window as an optimal-control problem in the order of its stages, for solvers that want it.

    min  ½‖L̄⁻¹ (x_0 - x̄)‖² + ½ Σ_k ‖present_k · residual(y_k, x_k) / σ‖² + ½ Σ_k ‖w̃_k + ω_k‖²
    s.t. δ_{k+1} = D⁻¹ (f(x_k, w̃_k + ω_k, Δt_k) - x̃_{k+1}),    x_k = x̃_k + D δ_k

Variables (δ_0, ω_0, δ_1, …, δ_N) are steps from the trajectory (x̃, w̃) in the scale D, with
which every state counts in its standard deviation. Bounds on states are bounds on δ. The
prior enters by the inverse of its Cholesky factor, made outside the clock.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from estimation.symbolic_stage import stacked_residual
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.tangent import away, is_plain, moved
from suites.speed.windows import SpeedWindow


@dataclass(frozen=True)
class StagewiseProblem:
    """A window's NLP, its variables and constraints stage by stage.

    Parameters
    ----------
    x, p : (n,) variables and parameters
    residual : (m,) whose half sum of squares is the cost
    gaps : (N n_x,) δ_{k+1} - …, zero where the dynamics hold
    """

    x: ca.SX
    p: ca.SX
    residual: ca.SX
    gaps: ca.SX

    @classmethod
    def build(cls, model: StateSpaceModel, horizon: int) -> StagewiseProblem:
        """Write down the problem for N intervals."""
        n_x, n_w, n_stages = model.n_x, model.n_w, horizon + 1
        x_prior, L_inverse = ca.SX.sym("x_prior", n_x), ca.SX.sym("L_inverse", n_x, n_x)
        y = ca.SX.sym("y", model.n_y, n_stages)
        present = ca.SX.sym("present", model.n_r, n_stages)
        dt, scale = ca.SX.sym("dt", horizon), ca.SX.sym("scale", n_x)
        x_around, w_around = ca.SX.sym("x_around", n_x, n_stages), ca.SX.sym("w", n_w, horizon)
        delta = [ca.SX.sym(f"delta_{k}", n_x) for k in range(n_stages)]
        omega = [ca.SX.sym(f"omega_{k}", n_w) for k in range(horizon)]

        x = [moved(model, x_around[:, k], scale * delta[k]) for k in range(n_stages)]
        residuals = [ca.tril(L_inverse) @ away(model, x[0], x_prior)]
        variables, gaps = [], []
        for k in range(n_stages):
            measured = stacked_residual(model, y[:, k], x[k])
            residuals.append(present[:, k] * measured / model.noise_std)
            variables.append(delta[k])
            if k < horizon:
                w = w_around[:, k] + omega[k]
                residuals.append(w)
                variables.append(omega[k])
                reached = model.f(x[k], w, dt[k])
                gaps.append(delta[k + 1] - away(model, reached, x_around[:, k + 1]) / scale)
        return cls(
            ca.vertcat(*variables),
            ca.veccat(x_prior, L_inverse, y, present, dt, scale, x_around, w_around),
            ca.vertcat(*residuals),
            ca.vertcat(*gaps),
        )


def stagewise_parameters(window: SpeedWindow) -> Array:
    """Return the parameters of a `StagewiseProblem`, linearised at the window's warm start."""
    parts = (
        window.prior.mean,
        window.prior_factor_inverse.ravel(order="F"),
        window.y.ravel(),
        window.present.ravel(),
        window.dt,
        window.scale,
        window.guess.states.ravel(),
        window.guess.noises.ravel(),
    )
    return np.concatenate(parts).astype(float)


def bounded_states(model: StateSpaceModel) -> list[int]:
    """Return the indices of the states that have a bound."""
    bounded = np.isfinite(model.lower) | np.isfinite(model.upper)
    return [int(i) for i in np.flatnonzero(bounded)]


def stagewise_bounds(window: SpeedWindow) -> tuple[Array, Array]:
    """Return (lower, upper) of the variables of a `StagewiseProblem`, ±inf where there is none."""
    model, guess = window.model, window.guess
    free = np.full((len(guess.states), model.n_w), np.inf)
    lower = np.hstack([(model.lower - guess.states) / window.scale, -free])
    upper = np.hstack([(model.upper - guess.states) / window.scale, free])
    return lower.ravel()[: -model.n_w], upper.ravel()[: -model.n_w]


def trajectory_of(variables: Array, window: SpeedWindow) -> Trajectory:
    """Return the trajectory of the variables (n,) of a `StagewiseProblem`."""
    n_x = window.model.n_x
    stages = np.append(variables, np.zeros(window.model.n_w)).reshape(len(window.measurements), -1)
    steps, around = window.scale * stages[:, :n_x], window.guess.states
    if is_plain(window.model):
        states = around + steps
    else:
        states = window.model.retract.map(len(around))(around.T, steps.T).full().T
    return Trajectory(states, window.guess.noises + stages[:-1, n_x:])
