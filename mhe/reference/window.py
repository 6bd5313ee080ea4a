"""The window problem of a moving horizon, symbolically, for one number of stages.

    min  ½‖w₋₁‖² + Σ_k ρ(present_k · residual(y_k, x_k) / σ) + Σ_k ρ(w_k)
    s.t. x_0 = x̄ ⊞ L̄ w₋₁,   x_{k+1} = f(x_k, w_k, Δt_k),   bounds, g(x_k) ≤ 0

Rows of g that a stage does not demand (`mhe.constraint_rows`) have no limit there.
L̄ is the Cholesky factor of the arrival cost's covariance: like the process
noise it enters as a unit noise w₋₁, so no covariance is ever inverted. ρ is half the sum of
squares, or Huber's loss of `mhe.loss` where the configuration has thresholds. States
are x_k = x̃_k ⊞ D δ_k around a given trajectory x̃, with D a diagonal scale; δ
and w are the decision variables. A bound on a state that adds is one on its δ: the solver never
leaves it, and asks no model for readings outside. Other bounds are constraints like g.

A window shorter than the horizon is padded in front with empty stages: Δt = 0, nothing
present and the first stage's inputs, which changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from scipy.linalg import solve_triangular

from estimation.kalman_stage import rows_present, without_gaps
from estimation.recording import Measurement
from estimation.symbolic_stage import stacked_residual
from mhe.config import WindowConfig
from mhe.constraint_rows import inequality_demanded
from mhe.domain import adding_states
from mhe.reference.terms import gauss_newton, squares, term
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class WindowProblem:
    """The NLP of a window with N intervals, and how to fill and read it.

    Parameters
    ----------
    model : the state-space model
    n_intervals : N; the window has N + 1 stages
    nlp : ``x, p, f, g`` for `casadi.nlpsol`
    cost : casadi.Function (decision variables, parameters) -> the objective
    gauss_newton : casadi.Function in the form of nlpsol's ``hess_lag``: JᵀΩJ of the residual
    curved : indices of the bounded states whose bounds are constraints
    boxed : indices of those whose bounds are the variables' own
    """

    model: StateSpaceModel
    n_intervals: int
    nlp: dict[str, ca.SX]
    cost: ca.Function
    gauss_newton: ca.Function
    curved: tuple[int, ...]
    boxed: tuple[int, ...]

    @classmethod
    def build(cls, model: StateSpaceModel, config: WindowConfig) -> WindowProblem:
        """Write down the problem for a model, a horizon and its losses, or find it written."""
        thresholds = config.thresholds([sensor.name for sensor in model.sensors])
        return _written(model, config.horizon, tuple(thresholds), config.noise_threshold)

    def parameters(
        self,
        prior: GaussianState,
        measurements: tuple[Measurement, ...],
        around: Array,
        scale: Array,
    ) -> Array:
        """Return the parameter vector of a window.

        Parameters
        ----------
        prior : of the first stage, given all measurements before the window
        measurements : at most N + 1 stages
        around : (n_stages, n_x) the trajectory x̃
        scale : (n_x,) diagonal of D
        """
        model, n_pad = self.model, self.n_padded(measurements)
        present = np.zeros((self.n_intervals + 1, model.n_r))
        y = np.zeros((self.n_intervals + 1, model.n_row))
        dt = np.zeros(self.n_intervals)
        for k, measurement in enumerate(measurements, start=n_pad):
            present[k] = rows_present(model, measurement.y)
            y[k] = without_gaps(measurement.y)
        y[:n_pad, model.n_y :] = y[n_pad, model.n_y :]
        times = np.array([measurement.time_s for measurement in measurements])
        dt[n_pad:] = np.diff(times)
        L_prior = np.linalg.cholesky(prior.covariance)
        return np.concatenate(
            [
                self._padded(around, n_pad).ravel(),
                prior.mean,
                L_prior.ravel(order="F"),
                y.ravel(),
                present.ravel(),
                dt,
                scale,
            ]
        )

    def limits(
        self, measurements: tuple[Measurement, ...], around: Array, scale: Array
    ) -> dict[str, Array]:
        """Return lbx, ubx, lbg and ubg as a solver wants them; padding stages demand nothing.

        Parameters
        ----------
        around, scale : see `parameters`
        """
        free_w = np.full(self.model.n_w, np.inf)
        boxed, first = list(self.boxed), np.full(self.model.n_x, np.inf)
        lower, upper = [-first], [first]
        n_pad = self.n_padded(measurements)
        for k in range(self.n_intervals + 1):
            low, high = -first, first.copy()
            if k >= n_pad:
                x, D = around[k - n_pad, boxed], scale[boxed]
                low[boxed] = (self.model.lower[boxed] - x) / D
                high[boxed] = (self.model.upper[boxed] - x) / D
            lower += [low, -free_w] if k < self.n_intervals else [low]
            upper += [high, free_w] if k < self.n_intervals else [high]
        lbg, ubg = self._constraint_bounds(measurements)
        return {
            "lbx": np.concatenate(lower),
            "ubx": np.concatenate(upper),
            "lbg": lbg,
            "ubg": ubg,
        }

    def _constraint_bounds(self, measurements: tuple[Measurement, ...]) -> tuple[Array, Array]:
        model, n_pad = self.model, self.n_padded(measurements)
        equal, n_g = np.zeros(model.n_x), int(model.inequality.numel_out(0))
        bounded = list(self.curved)
        lower, upper = [equal], [equal]
        for k in range(self.n_intervals + 1):
            real = k >= n_pad
            asked = np.zeros(n_g, dtype=bool)
            if real:
                asked = inequality_demanded(model, measurements[k - n_pad].y)
            lower += [np.where(real, model.lower[bounded], -np.inf), np.full(n_g, -np.inf)]
            upper += [np.where(real, model.upper[bounded], np.inf), np.where(asked, 0.0, np.inf)]
            if k < self.n_intervals:
                lower.append(equal)
                upper.append(equal)
        return np.concatenate(lower), np.concatenate(upper)

    def pack(self, prior: GaussianState, trajectory: Trajectory) -> Array:
        """Return the decision variables of a trajectory that is x̃ itself: δ = 0.

        w₋₁ is chosen so that the first constraint holds.
        """
        model = self.model
        away = np.asarray(model.difference(trajectory.states[0], prior.mean)).ravel()
        w_prior = solve_triangular(np.linalg.cholesky(prior.covariance), away, lower=True)
        stages = np.zeros((self.n_intervals, model.n_x + model.n_w))
        n_pad = self.n_intervals - len(trajectory.noises)
        stages[n_pad:, model.n_x :] = trajectory.noises
        return np.concatenate([w_prior, stages.ravel(), np.zeros(model.n_x)])

    def unpack(self, variables: Array, around: Array, scale: Array) -> Trajectory:
        """Return the trajectory of the real stages from the decision variables."""
        model = self.model
        n_pad = self.n_intervals + 1 - len(around)
        n_x, n_stage = model.n_x, model.n_x + model.n_w
        inner = variables[n_x : n_x + self.n_intervals * n_stage].reshape(-1, n_stage)
        delta = np.vstack([inner[:, :n_x], variables[-n_x:]])[n_pad:]
        states = np.array(
            [
                np.asarray(model.retract(x, scale * step)).ravel()
                for x, step in zip(around, delta, strict=True)
            ]
        )
        boxed = list(self.boxed)  # dividing and multiplying by the scale rounds
        states[:, boxed] = np.clip(states[:, boxed], model.lower[boxed], model.upper[boxed])
        return Trajectory(states, inner[n_pad:, n_x:])

    def n_padded(self, measurements: tuple[Measurement, ...]) -> int:
        """Return how many empty stages stand in front of a window."""
        return self.n_intervals + 1 - len(measurements)

    @staticmethod
    def _padded(around: Array, n_pad: int) -> Array:
        return np.vstack([np.repeat(around[:1], n_pad, axis=0), around])


@lru_cache(maxsize=2)  # one of 20 intervals is 30 MB
def _written(
    model: StateSpaceModel, n_intervals: int, thresholds: tuple[float, ...], noise_threshold: float
) -> WindowProblem:
    n_x, n_w, n_stages = model.n_x, model.n_w, n_intervals + 1
    bounded = np.flatnonzero(np.isfinite(model.lower) | np.isfinite(model.upper)).tolist()
    adding = adding_states(model)
    curved = tuple(i for i in bounded if i not in adding)
    boxed = tuple(i for i in bounded if i in adding)
    x_around = ca.SX.sym("x_around", n_x, n_stages)
    x_prior, L_prior = ca.SX.sym("x_prior", n_x), ca.SX.sym("L_prior", n_x, n_x)
    y = ca.SX.sym("y", model.n_row, n_stages)
    present = ca.SX.sym("present", model.n_r, n_stages)
    dt, scale = ca.SX.sym("dt", n_intervals), ca.SX.sym("scale", n_x)
    w_prior = ca.SX.sym("w_prior", n_x)
    delta = ca.SX.sym("delta", n_x, n_stages)
    w = ca.SX.sym("w", n_w, n_intervals)

    x = [model.retract(x_around[:, k], scale * delta[:, k]) for k in range(n_stages)]
    arrived = model.retract(x_prior, ca.tril(L_prior) @ w_prior)
    variables = [w_prior]
    constraints = [model.difference(x[0], arrived) / scale]
    terms = [squares(w_prior)]
    for k in range(n_stages):
        measured = stacked_residual(model, y[:, k], x[k])
        whitened, row = present[:, k] * measured / model.noise_std, 0
        for sensor, threshold in zip(model.sensors, thresholds, strict=True):
            terms.append(term(whitened[row : row + sensor.n_r], threshold))
            row += sensor.n_r
        variables.append(delta[:, k])
        constraints.append(ca.vertcat(ca.SX(0, 1), *(x[k][i] for i in curved)))
        constraints.append(model.inequality(x[k]))
        if k < n_intervals:
            variables.append(w[:, k])
            terms += [term(w[i, k], noise_threshold) for i in range(n_w)]
            inputs = model.step_inputs(y[:, k], y[:, k + 1])
            reached = model.f(x[k], w[:, k], dt[k], *inputs)
            constraints.append(model.difference(x[k + 1], reached) / scale)
    parameters = ca.veccat(x_around, x_prior, L_prior, y, present, dt, scale)
    nlp = {
        "x": ca.vertcat(*variables),
        "p": parameters,
        "f": sum((term.cost for term in terms), ca.SX(0)),
        "g": ca.densify(ca.vertcat(*constraints)),
    }
    cost = ca.Function("cost", [nlp["x"], parameters], [nlp["f"]], {"cse": True})
    return WindowProblem(model, n_intervals, nlp, cost, gauss_newton(nlp, terms), curved, boxed)
