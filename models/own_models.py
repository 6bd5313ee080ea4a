"""A model of one's own: states, a transition and sensors, without a pen.

Everything that a pen needs and a plain model does not has its usual value:
states that add, no bounds, no singular coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.manifold import additive_manifold, always_regular, no_inequality
from models.own_inputs import Inputs, own_inputs, takes_inputs
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
    reads : takes the symbolic state (n_x,), or the state and the model's inputs (n_u,), and
        returns (n_y,) expressions
    axes : axis → unit of each component of the reading, e.g. ``{"x": "m"}``
    noise_std : of every component, in its unit
    rate_hz : nominal rate, for the simulator
    """

    reads: Callable[..., ca.SX]
    axes: Mapping[str, str]
    noise_std: float
    rate_hz: float | None = None


def own_model(
    name: str,
    states: Mapping[str, tuple[float, float]],
    transition: Callable[..., ca.SX],
    n_noises: int,
    sensors: Mapping[str, OwnSensor],
    *,
    inputs: Inputs = (),
    interpolated: Iterable[str] = (),
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
    inputs : name → unit (``{"force_n": "N"}``), or names, of what is known at every instant:
        forces, set-points, parameters that vary in time. With some, transition is called with
        (x, w, Δt, u (n_u,)), and a sensor's `reads` may take (x, u). Values are a recording's
        `inputs`, or stand behind a measurement's readings; one that is missing is held
    interpolated : names of inputs of which a step takes the mean of both its ends; the others
        are held from its beginning

    Raises
    ------
    InputError
        If a state's name ends in no known unit, shapes do not fit together, a step
        of Δt = 0 changes the state, or an input's name is taken.
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
    x_next = _column(moved, n_x, f"model {name}: transition", "state")
    arguments = {"x": x, "w": w, "dt": dt, **ends}
    f = ca.Function("f", list(arguments.values()), [x_next], list(arguments), ["x_next"])
    _check_empty_step(name, tuple(states), f, mean, std)
    retract, difference = additive_manifold([False] * n_x)
    return StateSpaceModel(
        name=name,
        state_names=tuple(states),
        state_units=tuple(_unit(name, state) for state in states),
        f=f,
        sensors=tuple(
            _sensor(key, sensor, {"x": x}, dict(list(ends.items())[:1]))
            for key, sensor in sensors.items()
        ),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=np.full(n_x, -np.inf),
        upper=np.full(n_x, np.inf),
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
        input_names=given.names,
        input_units=given.units,
    )


def _taken(states: Iterable[str], sensors: Mapping[str, OwnSensor]) -> set[str]:
    """Return the names that no input may have: those of states, sensors and readings."""
    readings = {f"{name}_{axis}" for name, sensor in sensors.items() for axis in sensor.axes}
    return {*states, *sensors, *readings}


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
    inputs = [np.ones(f.numel_in(i)) for i in range(3, f.n_in())]
    moved = f(x, np.ones(f.numel_in(1)), 0.0, *inputs).full().ravel() - x
    rest = np.abs(moved) <= EMPTY_STEP_TOLERANCE * (np.abs(x) + std)
    if not rest.all():
        state = states[int(np.argmin(rest))]
        raise InputError(
            f"model {name}: a step of Δt = 0 changes {state}, expected that it changes nothing: "
            "scale noise by a power of Δt (white noise by √Δt)"
        )


def _sensor(
    name: str, sensor: OwnSensor, state: dict[str, ca.SX], inputs: dict[str, ca.SX]
) -> SensorModel:
    """Return a sensor that reads the symbols of the state, and of inputs where it takes them."""
    read = {**state, **inputs} if takes_inputs(sensor.reads) else state
    symbols, axes = list(read.values()), f"axis ({', '.join(sensor.axes)})"
    h = _column(sensor.reads(*symbols), len(sensor.axes), f"sensor {name}: its reading", axes)
    y = ca.SX.sym("y", len(sensor.axes))
    units = tuple(sensor.axes.values())
    return SensorModel(
        name=name,
        kind="own",
        axes=tuple(sensor.axes),
        unit_of_axis=units,
        h=ca.Function(f"h_{name}", symbols, [h], list(read), ["y"]),
        residual=ca.Function(f"residual_{name}", [y, *symbols], [y - h], ["y", *read], ["r"]),
        noise_std=np.full(y.numel(), sensor.noise_std),
        unit_of_row=units,
        rate_hz=sensor.rate_hz,
    )
