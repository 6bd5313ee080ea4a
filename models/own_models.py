"""A model of one's own: states, a transition and sensors, without a pen.

Everything that a pen needs and a plain model does not has its usual value:
states that add, no bounds, no singular coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.manifold import additive_manifold, always_regular, no_inequality
from models.names import several, unknown
from models.own_bounds import Bound, own_bounds
from models.own_sensors import OwnSensor, column, sensor_model
from models.state_space import StateSpaceModel
from models.units import readable_unit, split_unit

EMPTY_STEP_TOLERANCE = 1e-12
"""Rounding that a step of Δt = 0 may leave, of a state and its standard deviation."""


def own_model(
    name: str,
    states: Mapping[str, tuple[float, float]],
    transition: Callable[[ca.SX, ca.SX, ca.SX], ca.SX],
    n_noises: int,
    sensors: Mapping[str, OwnSensor],
    *,
    bounds: Mapping[str, Bound] | None = None,
    angles: Iterable[str] = (),
    units: Mapping[str, str] | None = None,
) -> StateSpaceModel:
    """Build a state-space model from plain functions of symbols.

    Parameters
    ----------
    name : for people
    states : name, that may end in its unit (``position_m``) → mean and standard deviation
        of what is known before the first measurement
    transition : (x (n_x,), w (n_noises,), Δt) → next x, with w ~ N(0, I); scale the
        noise inside it, so that a step of Δt = 0 changes nothing (white noise: by √Δt)
    n_noises : number of independent unit noises
    sensors : by name
    bounds : state → (lower, upper), in its unit; None or an infinity where there is none. The
        moving-horizon estimators obey them, a Kalman filter cannot
    angles : states that are angles on the circle, in radians: they are kept within (-π, π], and
        two of them differ by the short way round
    units : state → unit (``{"temp_K": "K"}``), of those whose name ends in no SI unit; a state
        with neither has none

    Raises
    ------
    InputError
        If shapes do not fit together, a step of Δt = 0 changes the state, a bound is empty, or
        a bound, an angle or a unit is of no state.
    """
    n_x = len(states)
    for state, known in states.items():
        if np.shape(known) != (2,) or not known[1] > 0:
            raise InputError(
                f"model {name}: state {state} starts from {known}, "
                "expected (mean, positive standard deviation)"
            )
    mean, std = np.array(list(states.values()), dtype=float).reshape(n_x, 2).T
    x, w, dt = ca.SX.sym("x", n_x), ca.SX.sym("w", n_noises), ca.SX.sym("dt")
    x_next = column(transition(x, w, dt), n_x, f"model {name}: transition", "state")
    f = ca.Function("f", [x, w, dt], [x_next], ["x", "w", "dt"], ["x_next"])
    _check_empty_step(name, tuple(states), f, mean, std)
    names = tuple(states)
    wrapped = several(angles)
    for state in (*wrapped, *(units or ())):
        if state not in states:
            raise unknown(f"model {name}: state", state, states)
    retract, difference = additive_manifold([state in wrapped for state in names])
    lower, upper = own_bounds(name, names, bounds or {})
    return StateSpaceModel(
        name=name,
        state_names=tuple(states),
        state_units=tuple((units or {}).get(state, _unit(state)) for state in names),
        f=f,
        sensors=tuple(sensor_model(key, sensor, x) for key, sensor in sensors.items()),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=lower,
        upper=upper,
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
    )


def _unit(state: str) -> str:
    """Return the SI unit that a name ends in, as people write it; nothing where there is none."""
    return readable_unit(split_unit(state)[1])


def _check_empty_step(
    name: str, states: tuple[str, ...], f: ca.Function, mean: Array, std: Array
) -> None:
    """Refuse a transition that needs no time: estimators take steps of Δt = 0."""
    n_w, signs = f.numel_in(1), (-1.0) ** np.arange(len(mean))
    for x, noise in ((mean + std, 1.0), (mean - std, -1.0), (mean + signs * std, 0.5)):
        moved = f(x, np.full(n_w, noise), 0.0).full().ravel() - x
        rest = np.abs(moved) <= EMPTY_STEP_TOLERANCE * (np.abs(x) + std)
        if rest.all():
            continue
        state = states[int(np.argmin(rest))]
        raise InputError(
            f"model {name}: a step of Δt = 0 changes {state}, expected that it changes nothing: "
            "scale noise by a power of Δt (white noise by √Δt)"
        )
