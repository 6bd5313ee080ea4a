"""A model of one's own: states, a transition and sensors, without a pen.

Everything that a pen needs and a plain model does not has its usual value:
states that add, no bounds, no singular coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import casadi as ca
import numpy as np

from models.empty_step import check_empty_step
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Known, known_values
from models.manifold import additive_manifold, always_regular, no_inequality
from models.names import several, unknown
from models.own_arguments import called, check_symbols
from models.own_bounds import Bound, own_bounds
from models.own_carried import SoftConstraint, carried_noises
from models.own_checks import check_parts
from models.own_inputs import Inputs, own_inputs
from models.own_parameters import OwnParts, with_parameters
from models.own_sensors import OwnSensor, column, sensor_model
from models.state_space import StateSpaceModel
from models.units import unit_ending


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
    noise_bounds: Mapping[int, Bound] | None = None,
    soft_constraints: Mapping[str, SoftConstraint] | None = None,
    inputs: Inputs = (),
    interpolated: Iterable[str] = (),
    parameters: Known | None = None,
    walks: Mapping[str, float] | None = None,
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
    noise_bounds : number of a noise → (lower, upper), in its deviations: ``{0: (0, None)}`` is a
        disturbance that never pulls back. The moving-horizon estimators obey them. The last w of
        each is one more state, ``noise_0``; that of a window's first stage led to it
    soft_constraints : name → (g, σ): g(x (n_x,)) should be ≤ 0, and costs ½ (g/σ)² where it is not.
        A smaller σ forbids more; ``x[0] - 2.0`` with 0.05 lets x[0] exceed 2 by some 0.05. The
        moving-horizon estimators obey them. The slack g/σ of each is one more state, by its name
    inputs : name → unit (``{"force_n": "N"}``), or names, of what is known at every instant:
        forces, set-points, parameters that vary in time. With some, transition is called with
        (x, w, Δt, u (n_u,)), and a sensor's `reads` may take (x, u). Values are a recording's
        `inputs`, or stand behind a measurement's readings; one that is missing is held
    interpolated : names of inputs of which a step takes the mean of both its ends; the others
        are held from its beginning
    parameters : name → mean and standard deviation, of constants to estimate. With some, transition
        is called with (x, w, Δt, p (n_p,)), or (x, w, Δt, u, p), and a sensor's `reads` may take
        (x, p), or (x, u, p). They are states behind the others, without noise; `bounds`, `angles`
        and `units` know them
    walks : parameter → standard deviation of its random walk, its unit per √s: larger follows it
        faster and knows it less. One that is not named is constant

    Raises
    ------
    InputError
        If shapes do not fit together, a step of Δt = 0 changes the state, a bound is empty, a
        bound, an angle or a unit is of no state, a bound of no noise, a soft constraint is not one
        expression with a deviation, or a name is taken.
    """
    bounded, soft = noise_bounds or {}, soft_constraints or {}
    named = {"bounds": bounds, "units": units, "walks": walks}
    check_parts(
        name, n_noises, sensors, {**named, "noise_bounds": bounded, "soft_constraints": soft}
    )
    if not states:
        raise InputError(f"model {name} has no states, expected at least one")
    parts = OwnParts(states, transition, n_noises, sensors)
    parts = with_parameters(name, parts, parameters or {}, walks or {}, has_inputs=bool(inputs))
    names, n_x = tuple(parts.states), len(parts.states)
    given = own_inputs(name, inputs, interpolated, _taken(parts.states, sensors))
    taken = {*_taken(parts.states, sensors), *given.names}
    carried = carried_noises(name, parts.n_noises, bounded, soft, taken=taken, n_x=n_x)
    mean, std = known_values(
        name, "state", {**parts.states, **dict.fromkeys(carried.names, (0.0, 1.0))}
    )
    x, w, dt = ca.SX.sym("x", len(mean)), ca.SX.sym("w", carried.n_w), ca.SX.sym("dt")
    ends, own = given.symbols(), x[:n_x]
    what, acting = f"model {name}: transition", given.over_step(*ends.values())
    moved = called(what, parts.transition, (own, w[: parts.n_noises], dt, *acting))
    x_next = column(moved, n_x, what, "state")
    x_next = ca.vertcat(x_next, carried.after_step(x[n_x:], w, dt))
    arguments = {"x": x, "w": w, "dt": dt, **ends}
    check_symbols(what, x_next, arguments)
    f = ca.Function("f", list(arguments.values()), [x_next], list(arguments), ["x_next"])
    wrapped = several(angles)
    for state in (*wrapped, *(units or ())):
        if state not in names:
            raise unknown(f"model {name}: state", state, names)
    every = (*names, *carried.names)
    retract, difference = additive_manifold([state in wrapped for state in every])
    lower, upper = own_bounds(name, names, bounds or {})
    limits = np.concatenate([lower, carried.lower]), np.concatenate([upper, carried.upper])
    check_empty_step(name, every, f, (mean, std), limits)
    of_names = (units or {}).get
    model = StateSpaceModel(
        name=name,
        state_names=every,
        state_units=(*(of_names(state, unit_ending(state)) for state in names), *carried.units),
        f=f,
        sensors=tuple(
            sensor_model(key, sensor, x, own, given.named(*ends.values()))
            for key, sensor in parts.sensors.items()
        ),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=limits[0],
        upper=limits[1],
        inequality=no_inequality(len(mean)),
        regularity=always_regular(len(mean)),
        input_names=given.names,
        input_units=given.units,
    )
    return model.constrained(carried.inequality) if soft else model


def _taken(states: Iterable[str], sensors: Mapping[str, OwnSensor]) -> set[str]:
    """Return the names that no input may have: those of states, sensors and readings."""
    readings = {f"{name}_{axis}" for name, sensor in sensors.items() for axis in sensor.axes}
    return {*states, *sensors, *readings}
