"""From a moving body and its sensors to a state-space model.

    x = (kinematic states, biases),   x_{k+1} = (step(x, w, Δt), b + walk √Δt w_b)

What a pen and a turntable have in common: choosing sensors by name, and the bias
states that these ask for.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.gaussian import GaussianState
from models.manifold import no_inequality
from models.names import expected_one_of, several
from models.outputs import Outputs, TangentNames
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.table import sensor_model
from models.state_space import StateSpaceModel
from models.units import readable_unit


@dataclass(frozen=True, eq=False)
class Kinematics:
    """The states of a motion and how they go on.

    Parameters
    ----------
    x : (n,) symbols of the states
    names, units : (n,) of the states
    step : takes x (n,), unit noises w (n,) and Δt (s), all symbols; returns the next state
    retract, difference : of the states' manifold, on symbols; see `models.state_space`
    mean, covariance : (n,), (n, n) what is known before the first measurement
    regularity : expression of `x`, near zero where its coordinates, or those that people read,
        are singular
    outputs : what people read of `x`; None where it is `x`
    tangent : tangent vectors in words of motions; None where the names of `x` do
    """

    x: ca.SX
    names: tuple[str, ...]
    units: tuple[str, ...]
    step: Callable[[ca.SX, ca.SX, ca.SX], ca.SX]
    retract: Callable[[ca.SX, ca.SX], ca.SX]
    difference: Callable[[ca.SX, ca.SX], ca.SX]
    mean: Array
    covariance: Array
    regularity: ca.SX
    outputs: Outputs | None = None
    tangent: TangentNames | None = None


def linear_step(
    transition: Callable[[ca.SX], ca.SX], factor: Callable[[ca.SX], ca.SX]
) -> Callable[[ca.SX, ca.SX, ca.SX], ca.SX]:
    """Return the step A(Δt) x + G(Δt) w."""
    return lambda x, w, dt: ca.mtimes(transition(dt), x) + ca.mtimes(factor(dt), w)


def choose_sensors(
    available: Mapping[str, Any], sensors: Iterable[str] | None, of: str
) -> dict[str, Any]:
    """Return the sensors of some names, in their order; None takes all.

    Raises
    ------
    InputError
        If a name is unknown or appears twice; `of` says what they are mounted on.
    """
    names = tuple(available) if sensors is None else several(sensors)
    for name in names:
        if name not in available:
            raise InputError(
                f"sensor {name} is not in the {of}; {expected_one_of(name, available)}"
            )
    if len(set(names)) < len(names):
        raise InputError(f"sensors {', '.join(names)}: a name appears twice, expected each once")
    return {name: available[name] for name in names}


def rest_of(available: Mapping[str, Any], chosen: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sensor of rest that goes with a choice of sensors, by name; {} where none does.

    The first that is detected, where a gyroscope is among the chosen and none of rest is.
    """
    if any(sensor.is_rest for sensor in chosen.values()):
        return {}
    if not any(sensor.reads_rate for sensor in chosen.values()):
        return {}
    found = ((name, sensor) for name, sensor in available.items() if sensor.makes_readings)
    return dict(itertools.islice(found, 1))


def check_rest(chosen: Mapping[str, Any], of: str) -> None:
    """Raise `InputError` unless detected rest has a gyroscope to be found from, and is one."""
    names = [name for name, sensor in chosen.items() if sensor.makes_readings]
    if len(names) > 1:
        raise InputError(f"{of}: sensors {', '.join(names)} detect rest, expected one at most")
    if names and not any(sensor.reads_rate for sensor in chosen.values()):
        raise InputError(
            f"{of}: sensor {names[0]} has no gyroscope to detect rest from, "
            "expected one among the sensors"
        )


def body_model(
    name: str, kinematics: Kinematics, body: MovingBody, sensors: Mapping[str, Any]
) -> StateSpaceModel:
    """Build the state-space model of a body that carries some sensors.

    Parameters
    ----------
    name : for people
    body : in the symbols of `kinematics`
    sensors : name → one of `models.sensor_kinds.table.KINDS`, in the order to stack them
    """
    biases = {key: sensor.bias_states(key) for key, sensor in sensors.items()}
    symbols = {key: ca.SX.sym(f"b_{key}", len(bias.names)) for key, bias in biases.items()}
    x = ca.vertcat(kinematics.x, *symbols.values())
    names = kinematics.names + tuple(state for bias in biases.values() for state in bias.names)
    of_state = [bias for bias in biases.values() for _ in bias.names]
    bias_means = [np.array(bias.mean) for bias in biases.values()]
    units = kinematics.units + tuple(readable_unit(bias.unit) for bias in of_state)
    n_x, n_b = len(names), len(of_state)
    covariance = np.zeros((n_x, n_x))
    covariance[: n_x - n_b, : n_x - n_b] = kinematics.covariance
    covariance[n_x - n_b :, n_x - n_b :] = np.diag([bias.std**2 for bias in of_state])
    retract, difference = _manifold(kinematics, n_b)
    return StateSpaceModel(
        name=name,
        state_names=names,
        state_units=units,
        f=_transition(kinematics, [bias.walk for bias in of_state]),
        sensors=tuple(
            sensor_model(key, sensor, body, x, symbols[key]) for key, sensor in sensors.items()
        ),
        prior=GaussianState(np.concatenate([kinematics.mean, *bias_means]), covariance),
        retract=retract,
        difference=difference,
        lower=np.full(n_x, -np.inf),
        upper=np.full(n_x, np.inf),
        inequality=no_inequality(n_x),
        regularity=ca.Function("regularity", [x], [kinematics.regularity], ["x"], ["margin"]),
        outputs=_outputs(kinematics.outputs, names[n_x - n_b :], units[n_x - n_b :]),
        tangent=_tangent(kinematics.tangent, names[n_x - n_b :], units[n_x - n_b :]),
    )


def _outputs(
    outputs: Outputs | None, names: tuple[str, ...], units: tuple[str, ...]
) -> Outputs | None:
    """Return outputs with biases behind them, read as they are."""
    if outputs is None:
        return None
    n_b, n = len(names), outputs.function.numel_in(0)
    x = ca.SX.sym("x", n + n_b)
    values = ca.vertcat(outputs.function(x[:n]), x[n:])
    return Outputs(
        outputs.names + names,
        outputs.units + units,
        ca.Function("outputs", [x], [values], ["x"], ["outputs"]),
        outputs.wrapped + (False,) * n_b,
    )


def _tangent(
    tangent: TangentNames | None, names: tuple[str, ...], units: tuple[str, ...]
) -> TangentNames | None:
    """Return names of tangent vectors with biases behind them."""
    if tangent is None:
        return None
    n_b, n = len(names), tangent.function.numel_in(0)
    x = ca.SX.sym("x", n + n_b)
    turned = ca.diagcat(tangent.function(x[:n]), ca.SX.eye(n_b))
    function = ca.Function("turned", [x], [ca.densify(turned)])
    return TangentNames(tangent.names + names, tangent.units + units, function)


def _transition(kinematics: Kinematics, walks: list[float]) -> ca.Function:
    """f(x, w, Δt): the kinematic part, and random walks on biases."""
    n, dt = len(kinematics.names), ca.SX.sym("dt")
    x, w = ca.SX.sym("x", n + len(walks)), ca.SX.sym("w", n + len(walks))
    moved = kinematics.step(x[:n], w[:n], dt)
    bias = x[n:] + ca.DM(walks) * ca.sqrt(dt) * w[n:]
    return ca.Function("f", [x, w, dt], [ca.vertcat(moved, bias)], ["x", "w", "dt"], ["x_next"])


def _manifold(kinematics: Kinematics, n_b: int) -> tuple[ca.Function, ca.Function]:
    """Return (retract, difference): that of the kinematic states, and biases added plainly."""
    n = len(kinematics.names)
    x, other, delta = (ca.SX.sym(name, n + n_b) for name in ("x", "other", "delta"))
    moved = ca.vertcat(kinematics.retract(x[:n], delta[:n]), x[n:] + delta[n:])
    away = ca.vertcat(kinematics.difference(x[:n], other[:n]), x[n:] - other[n:])
    return (
        ca.Function("retract", [x, delta], [moved], ["x", "delta"], ["x_moved"]),
        ca.Function("difference", [x, other], [away], ["to", "from"], ["delta"]),
    )
