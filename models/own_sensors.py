"""Sensors of a model of one's own: what they read, and how far from it they may be.

    r = residual(y, h(x)) ~ N(0, R)

With a full R = L Lᵀ the rows that estimators see are independent (`models.own_noise`). Row i holds
what reading i says beyond those before it, so it needs them all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.errors import InputError
from models.manifold import wrapped_angles
from models.names import several, unknown
from models.own_arguments import called, check_arguments, check_symbols, n_arguments
from models.own_noise import SIGMA, Covariance, Deviation, constant_noise, varies, whitened
from models.sensor_model import SensorModel


@dataclass(frozen=True, eq=False)
class OwnSensor:
    """A sensor that reads an expression of the state, in white noise.

    Parameters
    ----------
    reads : takes the symbolic state (n_x,), or the state and the model's inputs (n_u,), and
        returns (n_y,) expressions. On a pen it takes `models.pen_quantities.PenQuantities`
    axes : axis → unit of each component of the reading, e.g. ``{"x": "m"}``
    noise_std : of every component, or one for each (n_y,), in its unit; larger trusts it less.
        The name of one of the model's inputs (``"gps_std"``) stands for a deviation that is known
        with each reading; a function (u (n_u,)) → (n_y,) makes one of several. A reading whose
        deviation is not above zero says nothing. Innovations are then in standard deviations
    rate_hz : nominal rate, for the simulator
    noise_covariance : (n_y, n_y) R of components that err together, or a function (u (n_u,)) → R,
        instead of `noise_std`. A reading without one of its components says nothing by those
        after it
    wraps : axes that are angles on the circle, in radians: y - h is the short way round
    residual : (y (n_y,), h (n_y,)) → (n_y,), instead of y - h
    """

    reads: Callable[..., ca.SX]
    axes: Mapping[str, str]
    noise_std: Deviation = None
    rate_hz: float | None = None
    noise_covariance: Covariance = None
    wraps: Iterable[str] = ()
    residual: Callable[[ca.SX, ca.SX], ca.SX] | None = None


def column(expressions: ca.SX, n: int, what: str, per: str) -> ca.SX:
    """Return expressions as a dense column; CasADi would stretch or turn another shape.

    Raises
    ------
    InputError
        If there are not n of them.
    """
    is_list = isinstance(expressions, list | tuple)
    try:
        found = ca.densify(ca.vertcat(*expressions) if is_list else ca.SX(expressions))
    except (NotImplementedError, TypeError):
        raise InputError(
            f"{what} is {type(expressions).__name__}, expected ({n}, 1) expressions: "
            f"one row per {per}"
        ) from None
    if found.shape != (n, 1):
        raise InputError(f"{what} has shape {found.shape}, expected ({n}, 1): one row per {per}")
    return found


def sensor_model(
    name: str, sensor: OwnSensor, x: ca.SX, own: ca.SX, inputs: Mapping[str, ca.SX]
) -> SensorModel:
    """Return a sensor as the estimators see it; `InputError` where its parts do not fit.

    It reads the inputs where `reads` takes them or the noise depends on them.

    Parameters
    ----------
    x : symbol of the model's state
    own : the part of x that `reads` takes
    inputs : name → symbol of the model's inputs, entries of one vector
    """
    if (sensor.noise_std is None) == (sensor.noise_covariance is None):
        raise InputError(f"sensor {name}: expected either noise_std or noise_covariance")
    noise = sensor.noise_std, sensor.noise_covariance
    u = {"u": ca.vertcat(*inputs.values())} if inputs else {}
    reads_inputs = callable(sensor.reads) and n_arguments(sensor.reads) > 1
    check_arguments(f"sensor {name}: reads", sensor.reads, ("x", *u) if reads_inputs else ("x",))
    is_constant = not varies(*noise)
    read = {"x": x} if is_constant and not reads_inputs else {"x": x, **u}
    n, per = len(sensor.axes), f"axis ({', '.join(sensor.axes)})"
    what = f"sensor {name}: its reading"
    reading = called(what, sensor.reads, (own, *(u.values() if reads_inputs else ())))
    h = column(reading, n, what, per)
    check_symbols(what, h, read)
    y = ca.SX.sym("y", n)
    r = column(residual_of(name, sensor, y, h), n, f"sensor {name}: its residual", per)
    units = unit_of_row = tuple(sensor.axes.values())
    if is_constant:
        std, whitening = constant_noise(name, *noise, n)
        r = r if whitening is None else ca.sparsify(ca.DM(whitening)) @ r
    else:
        r, std, unit_of_row = whitened(name, r, *noise, dict(inputs)), np.ones(n), (SIGMA,) * n
    return SensorModel(
        name=name,
        kind="own",
        axes=tuple(sensor.axes),
        unit_of_axis=units,
        h=ca.Function(f"h_{name}", list(read.values()), [h], list(read), ["y"]),
        residual=ca.Function(f"residual_{name}", [y, *read.values()], [r], ["y", *read], ["r"]),
        noise_std=std,
        unit_of_row=unit_of_row,
        rate_hz=sensor.rate_hz,
    )


def residual_of(name: str, sensor: OwnSensor, y: ca.SX, h: ca.SX) -> ca.SX:
    """Return how far a reading y (n,) is from h (n,), before any noise; `InputError` at misfits."""
    wraps = several(sensor.wraps)
    for axis in wraps:
        if axis not in sensor.axes:
            raise unknown(f"sensor {name}: axis that wraps", axis, sensor.axes)
    if sensor.residual is None:
        return wrapped_angles(y - h, [axis in wraps for axis in sensor.axes])
    if wraps:
        raise InputError(f"sensor {name} has a residual and axes that wrap, expected one of them")
    return sensor.residual(y, h)
