"""Sensors of a model of one's own: what they read, and how far from it they may be.

    r = residual(y, h(x)) ~ N(0, R)

With a full R = L Lᵀ the rows that estimators see are diag(std) L⁻¹ r: independent, each in its
own unit. Row i holds what reading i says beyond those before it, so it needs them all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.manifold import wrapped_angles
from models.names import several, unknown
from models.own_arguments import check_arguments, n_arguments
from models.sensor_model import SensorModel


@dataclass(frozen=True, eq=False)
class OwnSensor:
    """A sensor that reads an expression of the state, in white noise.

    Parameters
    ----------
    reads : takes the symbolic state (n_x,), or the state and the model's inputs (n_u,), and
        returns (n_y,) expressions
    axes : axis → unit of each component of the reading, e.g. ``{"x": "m"}``
    noise_std : of every component, or one for each (n_y,), in its unit; larger trusts it less
    rate_hz : nominal rate, for the simulator
    noise_covariance : (n_y, n_y) R of components that err together, instead of `noise_std`. A
        reading without one of its components says nothing by those after it
    wraps : axes that are angles on the circle, in radians: y - h is the short way round
    residual : (y (n_y,), h (n_y,)) → (n_y,), instead of y - h
    """

    reads: Callable[..., ca.SX]
    axes: Mapping[str, str]
    noise_std: float | Sequence[float] | Array | None = None
    rate_hz: float | None = None
    noise_covariance: Sequence[Sequence[float]] | Array | None = None
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
    name: str, sensor: OwnSensor, state: Mapping[str, ca.SX], inputs: Mapping[str, ca.SX]
) -> SensorModel:
    """Return a sensor as the estimators see it; `InputError` where its parts do not fit.

    It reads the symbols of the state, and those of the inputs where `reads` takes them.
    """
    takes_inputs = callable(sensor.reads) and n_arguments(sensor.reads) > 1
    read = {**state, **inputs} if takes_inputs else dict(state)
    check_arguments(f"sensor {name}: reads", sensor.reads, tuple(read))
    symbols = list(read.values())
    n, per = len(sensor.axes), f"axis ({', '.join(sensor.axes)})"
    h = column(sensor.reads(*symbols), n, f"sensor {name}: its reading", per)
    y = ca.SX.sym("y", n)
    r = column(_residual(name, sensor, y, h), n, f"sensor {name}: its residual", per)
    std, whitening = _noise(name, sensor, n)
    units = tuple(sensor.axes.values())
    return SensorModel(
        name=name,
        kind="own",
        axes=tuple(sensor.axes),
        unit_of_axis=units,
        h=ca.Function(f"h_{name}", symbols, [h], list(read), ["y"]),
        residual=ca.Function(
            f"residual_{name}",
            [y, *symbols],
            [r if whitening is None else ca.sparsify(ca.DM(whitening)) @ r],
            ["y", *read],
            ["r"],
        ),
        noise_std=std,
        unit_of_row=units,
        rate_hz=sensor.rate_hz,
    )


def _residual(name: str, sensor: OwnSensor, y: ca.SX, h: ca.SX) -> ca.SX:
    wraps = several(sensor.wraps)
    for axis in wraps:
        if axis not in sensor.axes:
            raise unknown(f"sensor {name}: axis that wraps", axis, sensor.axes)
    if sensor.residual is None:
        return wrapped_angles(y - h, [axis in wraps for axis in sensor.axes])
    if wraps:
        raise InputError(f"sensor {name} has a residual and axes that wrap, expected one of them")
    return sensor.residual(y, h)


def _noise(name: str, sensor: OwnSensor, n: int) -> tuple[Array, Array | None]:
    """Return standard deviations (n,) and diag(std) L⁻¹ (n, n), None where R is diagonal."""
    if (sensor.noise_std is None) == (sensor.noise_covariance is None):
        raise InputError(f"sensor {name}: expected either noise_std or noise_covariance")
    if sensor.noise_std is not None:
        std = np.array(sensor.noise_std, dtype=float)
        if std.shape not in ((), (n,)):
            raise InputError(f"sensor {name}: noise_std has shape {std.shape}, expected ({n},)")
        return np.broadcast_to(std, (n,)).copy(), None
    R = np.array(sensor.noise_covariance, dtype=float)
    if R.shape != (n, n) or not np.allclose(R, R.T, rtol=1e-9, atol=0):
        raise InputError(
            f"sensor {name}: noise_covariance {R.shape}, expected symmetric ({n}, {n})"
        )
    try:
        L = np.linalg.cholesky(R)
    except np.linalg.LinAlgError:
        raise InputError(f"sensor {name}: noise_covariance is not positive definite") from None
    std = np.sqrt(np.diag(R))
    return std, np.tril(std[:, None] * np.linalg.inv(L))
