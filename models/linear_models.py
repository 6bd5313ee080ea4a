"""A linear system from its matrices.

continuous   d/dt x = A x + B u + G w,    w white noise of density Q
discrete     x_{k+1} = A x_k + B u_k + G w_k,   w ~ N(0, Q)
both         y_k = C x_k + D u_k + v_k,   v ~ N(0, R)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Known
from models.linear_matrices import (
    Matrix,
    Spread,
    covariance,
    first_state,
    matrix,
    names_of,
    noise_density,
    units_of,
)
from models.linear_steps import continuous_steps, discrete_steps, step_matrix
from models.own_bounds import Bound
from models.own_inputs import Inputs
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel

SENSOR = "y"
"""Name of the one sensor of a linear model."""


def linear_model(
    name: str,
    A: Matrix,
    C: Matrix,
    *,
    Q: Matrix | None = None,
    G: Matrix | None = None,
    R: Matrix,
    prior: GaussianState | Known | Spread,
    dt_s: float | None = None,
    B: Matrix | None = None,
    D: Matrix | None = None,
    states: Iterable[str] = (),
    readings: Inputs = (),
    inputs: Inputs = (),
    interpolated: Iterable[str] = (),
    units: Mapping[str, str] | None = None,
    bounds: Mapping[str, Bound] | None = None,
    rate_hz: float | None = None,
) -> StateSpaceModel:
    """Build a state-space model from matrices; see the module's equations.

    Parameters
    ----------
    name : for people
    A, C : (n_x, n_x) and (n_y, n_x)
    Q, G : (n_w, n_w) and (n_x, n_w); Q alone is (n_x, n_x), G alone has unit noises. At least one,
        ``Q=0`` has no noise. A larger Q believes the readings more and the equation less
    R : (n_y, n_y) covariance of the readings, positive definite; a number is the same for all
    prior : what is known before the first reading: (mean, deviations or covariance), a number
        being the same for all, or as of `estimation.estimator.run`
    dt_s : sample interval of discrete matrices, s: instants are whole numbers of it apart, within
        5 %, and others are refused. None takes A, B and Q for continuous ones, whose steps may have
        any length: e^{A Δt}, and noise and held inputs integrated exactly
    B, D : (n_x, n_u) and (n_y, n_u) of known inputs; without D a reading does not show them
    states, readings, inputs : names; ``x1``, ``1``, ``u1``, … without. Names may end in their unit,
        or be name → unit for readings and inputs. Readings are those of one sensor, ``y``
    interpolated, units, bounds : see `models.own_models.own_model`
    rate_hz : of the readings, for the simulator; 1 / dt_s by default

    Raises
    ------
    InputError
        If a shape does not fit, a matrix is not finite, or Q or R is no covariance.
    """
    where = f"model {name}"
    A = matrix(where, "A", A, (None, None))
    n_x = len(A)
    A, C = matrix(where, "A", A, (n_x, n_x)), matrix(where, "C", C, (None, n_x))
    n_y = len(C)
    B = np.zeros((n_x, 0)) if B is None else matrix(where, "B", B, (n_x, None))
    n_u = B.shape[1]
    D = np.zeros((n_y, n_u)) if D is None else matrix(where, "D", D, (n_y, n_u))
    density, R = noise_density(where, Q, G, n_x), covariance(where, "R", R, n_y)
    if dt_s is not None and not (isinstance(dt_s, int | float) and 0 < dt_s < np.inf):
        raise InputError(f"{where}: dt_s is {dt_s!r}, expected a positive time, or None")
    of_states = names_of(where, "states", states, n_x, "x")
    known = first_state(name, of_states, prior)
    moved = _moved(A, density)
    is_full = bool((R - np.diag(np.diag(R))).any())
    sensor = OwnSensor(
        _reads(C, D),
        units_of(where, "readings", readings, n_y, ""),
        noise_covariance=R if is_full else None,
        noise_std=None if is_full else np.sqrt(np.diag(R)),
        rate_hz=rate_hz if dt_s is None or rate_hz is not None else 1 / dt_s,
    )
    model = own_model(
        name,
        {state: (m, s) for state, m, s in zip(of_states, known.mean, known.std, strict=True)},
        _transition(A, B, density, moved, dt_s),
        len(moved),
        {SENSOR: sensor},
        inputs=units_of(where, "inputs", inputs, n_u, "u"),
        interpolated=interpolated,
        units=units,
        bounds=bounds,
    )
    return model.replace(prior=known, interval_s=dt_s)


def _moved(A: Array, density: Array) -> list[int]:
    """Return the indices of states that noise reaches, at once or through others."""
    reached = density.any(axis=1)
    for _ in A:
        reached = reached | A[:, reached].any(axis=1)
    return [int(i) for i in np.flatnonzero(reached)]


def _reads(C: Array, D: Array) -> Callable[..., ca.SX]:
    of_state, of_inputs = ca.sparsify(ca.DM(C)), ca.sparsify(ca.DM(D))
    if D.any():
        return lambda x, u: of_state @ x + of_inputs @ u
    return lambda x: of_state @ x


def _transition(
    A: Array, B: Array, density: Array, moved: list[int], dt_s: float | None
) -> Callable[..., ca.SX]:
    """Return (x, w, Δt) → next x, or (x, w, Δt, u) with inputs: they are states that stay."""
    n_x, n_u = B.shape
    joint, noise = np.zeros((n_x + n_u, n_x + n_u)), np.zeros((n_x + n_u, n_x + n_u))
    joint[:n_x], noise[:n_x, :n_x] = np.hstack([A, B]), density
    if dt_s is None:
        steps = continuous_steps(joint, noise)
    else:
        joint[n_x:, n_x:] = np.eye(n_u)
        steps = discrete_steps(joint, noise, dt_s)

    matrix = step_matrix(steps, n_x, moved)

    def with_inputs(x: ca.SX, w: ca.SX, dt: ca.SX, u: ca.SX) -> ca.SX:
        return matrix(dt) @ ca.vertcat(x, u, w)

    def without(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        return matrix(dt) @ ca.vertcat(x, w)

    return with_inputs if n_u else without
