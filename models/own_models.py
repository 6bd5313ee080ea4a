"""A model of one's own: states, a transition and sensors, without a pen.

Everything that a pen needs and a plain model does not has its usual value:
states that add, no bounds, no singular coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.manifold import additive_manifold, always_regular, no_inequality
from models.own_bounds import Bound, own_bounds
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from models.units import UNITS, readable_unit, split_unit

EMPTY_STEP_TOLERANCE = 1e-12
"""Rounding that a step of Δt = 0 may leave, of a state and its standard deviation."""


@dataclass(frozen=True)
class OwnSensor:
    """A sensor that reads an expression of the state, in white noise.

    Parameters
    ----------
    reads : takes the symbolic state (n_x,) and returns (n_y,) expressions
    axes : axis → unit of each component of the reading, e.g. ``{"x": "m"}``
    noise_std : of every component, in its unit
    rate_hz : nominal rate, for the simulator
    """

    reads: Callable[[ca.SX], ca.SX]
    axes: Mapping[str, str]
    noise_std: float
    rate_hz: float | None = None


def own_model(
    name: str,
    states: Mapping[str, tuple[float, float]],
    transition: Callable[[ca.SX, ca.SX, ca.SX], ca.SX],
    n_noises: int,
    sensors: Mapping[str, OwnSensor],
    *,
    bounds: Mapping[str, Bound] | None = None,
) -> StateSpaceModel:
    """Build a state-space model from plain functions of symbols.

    Parameters
    ----------
    name : for people
    states : name that ends in its unit (``position_m``) → mean and standard deviation
        of what is known before the first measurement
    transition : (x (n_x,), w (n_noises,), Δt) → next x, with w ~ N(0, I); scale the
        noise inside it, so that a step of Δt = 0 changes nothing (white noise: by √Δt)
    n_noises : number of independent unit noises
    sensors : by name
    bounds : state → (lower, upper), in its unit; None or an infinity where there is none. The
        moving-horizon estimators obey them, a Kalman filter cannot

    Raises
    ------
    InputError
        If a state's name ends in no known unit, shapes do not fit together, a step
        of Δt = 0 changes the state, or a bound is empty or on no state.
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
    x_next = _column(transition(x, w, dt), n_x, f"model {name}: transition", "state")
    f = ca.Function("f", [x, w, dt], [x_next], ["x", "w", "dt"], ["x_next"])
    _check_empty_step(name, tuple(states), f, mean, std)
    retract, difference = additive_manifold([False] * n_x)
    lower, upper = own_bounds(name, tuple(states), bounds or {})
    return StateSpaceModel(
        name=name,
        state_names=tuple(states),
        state_units=tuple(_unit(name, state) for state in states),
        f=f,
        sensors=tuple(_sensor(key, sensor, x) for key, sensor in sensors.items()),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=lower,
        upper=upper,
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
    )


def _unit(model: str, state: str) -> str:
    unit = split_unit(state)[1]
    if not unit:
        raise InputError(
            f"model {model}: state {state} ends in no unit, expected one of {', '.join(UNITS)}"
        )
    return readable_unit(unit)


def _column(expressions: ca.SX, n: int, what: str, per: str) -> ca.SX:
    """Return expressions as a dense column; CasADi would stretch or turn another shape."""
    column = ca.densify(ca.SX(expressions))
    if column.shape != (n, 1):
        raise InputError(f"{what} has shape {column.shape}, expected ({n}, 1): one row per {per}")
    return column


def _check_empty_step(
    name: str, states: tuple[str, ...], f: ca.Function, mean: Array, std: Array
) -> None:
    """Refuse a transition that needs no time: estimators take steps of Δt = 0."""
    x = mean + std
    moved = f(x, np.ones(f.numel_in(1)), 0.0).full().ravel() - x
    rest = np.abs(moved) <= EMPTY_STEP_TOLERANCE * (np.abs(x) + std)
    if not rest.all():
        state = states[int(np.argmin(rest))]
        raise InputError(
            f"model {name}: a step of Δt = 0 changes {state}, expected that it changes nothing: "
            "scale noise by a power of Δt (white noise by √Δt)"
        )


def _sensor(name: str, sensor: OwnSensor, x: ca.SX) -> SensorModel:
    axes = f"axis ({', '.join(sensor.axes)})"
    h = _column(sensor.reads(x), len(sensor.axes), f"sensor {name}: its reading", axes)
    y = ca.SX.sym("y", len(sensor.axes))
    units = tuple(sensor.axes.values())
    return SensorModel(
        name=name,
        kind="own",
        axes=tuple(sensor.axes),
        unit_of_axis=units,
        h=ca.Function(f"h_{name}", [x], [h], ["x"], ["y"]),
        residual=ca.Function(f"residual_{name}", [y, x], [y - h], ["y", "x"], ["r"]),
        noise_std=np.full(y.numel(), sensor.noise_std),
        unit_of_row=units,
        rate_hz=sensor.rate_hz,
    )
