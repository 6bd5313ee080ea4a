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
from models.own_inputs import Inputs, own_inputs
from models.own_sensors import OwnSensor, column, sensor_model
from models.state_space import StateSpaceModel
from models.units import readable_unit, split_unit

EMPTY_STEP_TOLERANCE = 1e-12
"""Rounding that a step of Δt = 0 may leave, of a state and its standard deviation."""
SOME_STEP_S = 1e-3
"""A step from a state where the model is defined has a result."""


def own_model(
    name: str,
    states: Mapping[str, tuple[float, float]],
    transition: Callable[..., ca.SX],
    n_noises: int,
    sensors: Mapping[str, OwnSensor],
    *,
    bounds: Mapping[str, Bound] | None = None,
    angles: Iterable[str] = (),
    units: Mapping[str, str] | None = None,
    inputs: Inputs = (),
    interpolated: Iterable[str] = (),
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
    inputs : name → unit (``{"force_n": "N"}``), or names, of what is known at every instant:
        forces, set-points, parameters that vary in time. With some, transition is called with
        (x, w, Δt, u (n_u,)), and a sensor's `reads` may take (x, u). Values are a recording's
        `inputs`, or stand behind a measurement's readings; one that is missing is held
    interpolated : names of inputs of which a step takes the mean of both its ends; the others
        are held from its beginning

    Raises
    ------
    InputError
        If shapes do not fit together, a step of Δt = 0 changes the state, a bound is empty, a
        bound, an angle or a unit is of no state, or an input's name is taken.
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
    given = own_inputs(name, inputs, interpolated, _taken(states, sensors))
    ends = given.symbols()
    moved = transition(x, w, dt, *given.over_step(*ends.values()))
    x_next = column(moved, n_x, f"model {name}: transition", "state")
    arguments = {"x": x, "w": w, "dt": dt, **ends}
    f = ca.Function("f", list(arguments.values()), [x_next], list(arguments), ["x_next"])
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
        sensors=tuple(
            sensor_model(key, sensor, {"x": x}, dict(list(ends.items())[:1]))
            for key, sensor in sensors.items()
        ),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=lower,
        upper=upper,
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
        input_names=given.names,
        input_units=given.units,
    )


def _taken(states: Iterable[str], sensors: Mapping[str, OwnSensor]) -> set[str]:
    """Return the names that no input may have: those of states, sensors and readings."""
    readings = {f"{name}_{axis}" for name, sensor in sensors.items() for axis in sensor.axes}
    return {*states, *sensors, *readings}


def _unit(state: str) -> str:
    """Return the SI unit that a name ends in, as people write it; nothing where there is none."""
    return readable_unit(split_unit(state)[1])


def _check_empty_step(
    name: str, states: tuple[str, ...], f: ca.Function, mean: Array, std: Array
) -> None:
    """Refuse a transition that needs no time: estimators take steps of Δt = 0."""
    n_w, signs = f.numel_in(1), (-1.0) ** np.arange(len(mean))
    inputs = [np.ones(f.numel_in(i)) for i in range(3, f.n_in())]
    for x, noise in ((mean + std, 1.0), (mean - std, -1.0), (mean + signs * std, 0.5)):
        empty, some = (
            f(x, np.full(n_w, noise), dt, *inputs).full().ravel() for dt in (0.0, SOME_STEP_S)
        )
        rest = np.abs(empty - x) <= EMPTY_STEP_TOLERANCE * (np.abs(x) + std)
        rest |= ~np.isfinite(some)  # a rod of no length: such a state says nothing
        if rest.all():
            continue
        state = states[int(np.argmin(rest))]
        raise InputError(
            f"model {name}: a step of Δt = 0 changes {state}, expected that it changes nothing: "
            "scale noise by a power of Δt (white noise by √Δt)"
        )
