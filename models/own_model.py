"""A model of one's own: states, a transition and sensors, without a pen.

Everything that a pen needs and a plain model does not has its usual value:
states that add, no bounds, no singular coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.errors import InputError
from models.gaussian import GaussianState
from models.manifold import additive_manifold, always_regular, no_inequality
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from models.units import UNITS, split_unit


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
) -> StateSpaceModel:
    """Build a state-space model from plain functions of symbols.

    Parameters
    ----------
    name : for people
    states : name that ends in its unit (``position_m``) → mean and standard deviation
        of what is known before the first measurement
    transition : (x (n_x,), w (n_noises,), Δt) → next x, with w ~ N(0, I); scale the
        noise inside it
    n_noises : number of independent unit noises
    sensors : by name

    Raises
    ------
    InputError
        If a state's name ends in no known unit, or shapes do not fit together.
    """
    n_x = len(states)
    x, w, dt = ca.SX.sym("x", n_x), ca.SX.sym("w", n_noises), ca.SX.sym("dt")
    mean, std = np.array(list(states.values()), dtype=float).reshape(n_x, 2).T
    retract, difference = additive_manifold([False] * n_x)
    f = ca.Function(
        "f", [x, w, dt], [ca.densify(transition(x, w, dt))], ["x", "w", "dt"], ["x_next"]
    )
    return StateSpaceModel(
        name=name,
        state_names=tuple(states),
        state_units=tuple(_unit(name, state) for state in states),
        f=f,
        sensors=tuple(_sensor(key, sensor, x) for key, sensor in sensors.items()),
        prior=GaussianState(mean, np.diag(std**2)),
        retract=retract,
        difference=difference,
        lower=np.full(n_x, -np.inf),
        upper=np.full(n_x, np.inf),
        inequality=no_inequality(n_x),
        regularity=always_regular(n_x),
    )


def _unit(model: str, state: str) -> str:
    unit = split_unit(state)[1]
    if not unit:
        raise InputError(
            f"model {model}: state {state} ends in no unit, expected one of {', '.join(UNITS)}"
        )
    return unit


def _sensor(name: str, sensor: OwnSensor, x: ca.SX) -> SensorModel:
    h = ca.densify(sensor.reads(x))
    y = ca.SX.sym("y", len(sensor.axes))
    if h.numel() != y.numel():
        raise InputError(
            f"sensor {name} reads {h.numel()} components, expected {y.numel()}: "
            f"one per axis ({', '.join(sensor.axes)})"
        )
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
