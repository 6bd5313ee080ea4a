"""Constant parameters to estimate: states that stay as they are, or walk slowly.

    p_{k+1} = p_k + s √Δt w_p,   p_0 ~ N(mean, std²)

No noise moves a parameter that does not walk: readings only ever make it better known.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import is_real
from models.errors import InputError
from models.given_prior import Known, known_values
from models.names import unknown
from models.own_arguments import called, check_arguments, n_arguments
from models.own_sensors import OwnSensor, column


@dataclass(frozen=True, eq=False)
class OwnParts:
    """What a model of one's own is built from; see `models.own_models.own_model`."""

    states: Known
    transition: Callable[..., ca.SX]
    n_noises: int
    sensors: Mapping[str, OwnSensor]


def with_parameters(
    model: str, own: OwnParts, parameters: Known, walks: Mapping[str, float], *, has_inputs: bool
) -> OwnParts:
    """Return a model's parts with parameters p (n_p,) as states behind its own.

    Parameters
    ----------
    model : its name
    own : its parts; with parameters, transition and `reads` take p as their last argument
    parameters : name → mean and standard deviation
    walks : parameter → standard deviation of its random walk, its unit per √s
    has_inputs : whether it has known inputs; they come before p

    Raises
    ------
    InputError
        If a function takes other arguments, a parameter has a state's name, or a walk is of no
        parameter or no positive number.
    """
    known_values(model, "state", own.states)
    known_values(model, "parameter", parameters)
    given = ("x", "w", "dt", *(("u",) if has_inputs else ()), *(("p",) if parameters else ()))
    check_arguments(f"model {model}: transition", own.transition, given)
    for name in parameters:
        if name in own.states:
            raise InputError(
                f"model {model}: parameter {name} is the name of a state, "
                "expected a name of its own"
            )
    for name, density in walks.items():
        if name not in parameters:
            raise unknown(f"model {model}: walk of parameter", name, parameters)
        if not (is_real(density) and 0 < density < np.inf):
            raise InputError(
                f"model {model}: parameter {name} walks by {density!r}, "
                "expected a positive number, its unit per √s"
            )
    return _augmented(model, own, parameters, walks, has_inputs) if parameters else own


def _augmented(
    model: str, own: OwnParts, parameters: Known, walks: Mapping[str, float], has_inputs: bool
) -> OwnParts:
    n_x, n_w = len(own.states), own.n_noises
    walking = [name for name in parameters if name in walks]

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, *inputs: ca.SX) -> ca.SX:
        noise = w[:n_w] if n_w else ca.SX(0, 1)
        what = f"model {model}: transition"
        moved = called(what, own.transition, (x[:n_x], noise, dt, *inputs, x[n_x:]))
        walked = x[n_x:]
        for i, name in enumerate(parameters):
            if name in walks:
                walked[i] += walks[name] * ca.sqrt(dt) * w[n_w + walking.index(name)]
        return ca.vertcat(column(moved, n_x, what, "state"), walked)

    return OwnParts(
        {**own.states, **parameters},
        transition,
        n_w + len(walking),
        {name: _sensor(name, sensor, n_x, has_inputs) for name, sensor in own.sensors.items()},
    )


def _sensor(name: str, sensor: OwnSensor, n_x: int, has_inputs: bool) -> OwnSensor:
    """Return a sensor that reads the state with the parameters behind it."""
    reads = sensor.reads
    n = n_arguments(reads) if callable(reads) else 0
    taken = ("x", "u", "p") if has_inputs else ("x", "p")
    check_arguments(f"sensor {name}: reads", reads, taken[: max(n, 1)])
    if has_inputs and n > 1:

        def of_inputs(x: ca.SX, u: ca.SX) -> ca.SX:
            return reads(x[:n_x], u, x[n_x:]) if n > 2 else reads(x[:n_x], u)

        return dataclasses.replace(sensor, reads=of_inputs)

    def of_state(x: ca.SX) -> ca.SX:
        return reads(x[:n_x], x[n_x:]) if n > 1 else reads(x[:n_x])

    return dataclasses.replace(sensor, reads=of_state)
