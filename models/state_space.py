"""The state-space model: a frozen value that every estimator reads.

    x_{k+1} = f(x_k, w_k, Δt),   w ~ N(0, I)
    0 ≈ residual(y, x) ~ N(0, diag(noise_std²))

States may live on a manifold: ``retract(x, δ)`` moves a state by a tangent
vector, ``difference(a, b)`` is the tangent vector from b to a.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GaussianState:
    """A Gaussian over the state: mean (n_x,) and covariance (n_x, n_x), model units."""

    mean: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations (n_x,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One sensor as the estimators see it.

    Parameters
    ----------
    name : its name in the pen file
    kind : one of `models.sensors.SENSOR_KINDS`, for display only
    axes, unit_of_axis : the components of a reading y and their units
    h : casadi.Function (n_x,) -> (n_y,), the reading without noise
    residual : casadi.Function (n_y,), (n_x,) -> (n_r,), y "minus" h(x); its rows
        are in the unit of `noise_std`
    noise_std, unit_of_row : (n_r,) standard deviation and unit of the residual's rows
    rate_hz, delay_s : see `models.sensors.SensorBase`
    constant_reading : (n_y,) for a sensor without readings of its own, else None
    reading_limit : |y| at or beyond it is saturated, in the reading's unit
    """

    name: str
    kind: str
    axes: tuple[str, ...]
    unit_of_axis: tuple[str, ...]
    h: ca.Function
    residual: ca.Function
    noise_std: Array
    unit_of_row: tuple[str, ...]
    rate_hz: float | None = None
    delay_s: float = 0.0
    constant_reading: Array | None = None
    reading_limit: float | None = None

    @property
    def n_y(self) -> int:
        """Number of components of a reading."""
        return len(self.axes)

    @property
    def n_r(self) -> int:
        """Number of rows of the residual."""
        return len(self.noise_std)

    @cached_property
    def row_needs(self) -> NDArray[np.bool_]:
        """(n_r, n_y): which components of y each row of the residual depends on."""
        pattern = self.residual.sparsity_jac(0, 0)
        return np.array(ca.DM(pattern, 1).full() != 0)


@dataclass(frozen=True, eq=False)
class StateSpaceModel:
    """A model of motion with its sensors; see the module's equations.

    Parameters
    ----------
    name : for people
    state_names : (n_x,) names that end in their unit
    f : casadi.Function (n_x,), (n_w,), () -> (n_x,); Δt in seconds is the last argument
    sensors : in the order in which their readings are stacked
    prior : what is known of the state before the first measurement
    retract, difference : casadi.Function (n_x,), (n_d,) -> (n_x,) and (n_x,), (n_x,) -> (n_d,)
    lower, upper : (n_x,) bounds, ±inf where there is none
    inequality : casadi.Function (n_x,) -> (n_g,), every row must be ≤ 0
    regularity : casadi.Function (n_x,) -> (), near zero where the coordinates are singular
    """

    name: str
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    f: ca.Function
    sensors: tuple[SensorModel, ...]
    prior: GaussianState
    retract: ca.Function
    difference: ca.Function
    lower: Array
    upper: Array
    inequality: ca.Function
    regularity: ca.Function

    def __post_init__(self) -> None:
        _check_shapes(self)

    @property
    def n_x(self) -> int:
        """Number of states."""
        return len(self.state_names)

    @property
    def n_w(self) -> int:
        """Number of independent unit noises that drive the state."""
        return int(self.f.numel_in(1))

    @property
    def n_y(self) -> int:
        """Number of components of all readings stacked."""
        return sum(sensor.n_y for sensor in self.sensors)

    @property
    def n_r(self) -> int:
        """Number of rows of all residuals stacked."""
        return sum(sensor.n_r for sensor in self.sensors)

    @cached_property
    def noise_std(self) -> Array:
        """(n_r,) standard deviations of the stacked residual."""
        return np.concatenate([np.zeros(0), *(sensor.noise_std for sensor in self.sensors)])

    @cached_property
    def row_needs(self) -> NDArray[np.bool_]:
        """(n_r, n_y): which components of y each row of the stacked residual needs."""
        needs = np.zeros((self.n_r, self.n_y), dtype=bool)
        row = column = 0
        for sensor in self.sensors:
            needs[row : row + sensor.n_r, column : column + sensor.n_y] = sensor.row_needs
            row, column = row + sensor.n_r, column + sensor.n_y
        return needs

    @cached_property
    def reading_names(self) -> tuple[str, ...]:
        """(n_y,) names of the stacked readings: ``accel_x``, …"""
        return tuple(f"{sensor.name}_{axis}" for sensor in self.sensors for axis in sensor.axes)

    def sensor(self, name: str) -> SensorModel:
        """Return a sensor by name; raises `InputError` for an unknown one."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        known = ", ".join(sensor.name for sensor in self.sensors)
        raise InputError(f"sensor {name} is not part of the model {self.name}; expected {known}")

    def stack(self, readings: Mapping[str, Array]) -> Array:
        """Stack readings by sensor name into y (n_y,), NaN where there is none."""
        parts = []
        for sensor in self.sensors:
            value = np.asarray(readings.get(sensor.name, np.full(sensor.n_y, np.nan)), dtype=float)
            if value.shape != (sensor.n_y,):
                raise InputError(
                    f"reading of {sensor.name} has shape {value.shape}, expected ({sensor.n_y},)"
                )
            parts.append(value)
        return np.concatenate([np.zeros(0), *parts])

    def replace(self, **changes: object) -> StateSpaceModel:
        """Return a copy with some fields changed."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def bounded(self, **bounds: tuple[float, float]) -> StateSpaceModel:
        """Return a copy with (lower, upper) bounds on states given by name."""
        lower, upper = self.lower.copy(), self.upper.copy()
        for state, (low, high) in bounds.items():
            if state not in self.state_names:
                raise InputError(
                    f"bound on unknown state {state}; expected one of {', '.join(self.state_names)}"
                )
            if not low < high:
                raise InputError(f"bound on {state}: lower {low} is not below upper {high}")
            index = self.state_names.index(state)
            lower[index], upper[index] = low, high
        return self.replace(lower=lower, upper=upper)

    def constrained(self, inequality: Callable[[ca.SX], ca.SX]) -> StateSpaceModel:
        """Return a copy that also demands ``inequality(x) <= 0``, row by row.

        Parameters
        ----------
        inequality : takes the symbolic state (n_x,) and returns (n_g,) expressions
        """
        x = ca.SX.sym("x", self.n_x)
        rows = ca.vertcat(self.inequality(x), inequality(x))
        return self.replace(inequality=ca.Function("inequality", [x], [rows], ["x"], ["g"]))

    def __repr__(self) -> str:
        lines = [f"StateSpaceModel {self.name}: {self.n_x} states, {self.n_w} noises"]
        for name, mean, std in zip(self.state_names, self.prior.mean, self.prior.std, strict=True):
            lines.append(f"  {name:32s} prior {mean:10.4g} ± {std:.4g}")
        for sensor in self.sensors:
            rate = f"{sensor.rate_hz:g} Hz" if sensor.rate_hz else "as recorded"
            noise = _noise_text(sensor)
            lines.append(f"  {sensor.name} ({sensor.kind}, {rate}): noise {noise}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{unit}</td><td>{mean:.4g} ± {std:.4g}</td></tr>"
            for name, unit, mean, std in zip(
                self.state_names, self.state_units, self.prior.mean, self.prior.std, strict=True
            )
        )
        sensors = "".join(
            f"<tr><td>{sensor.name}</td><td>{sensor.kind}</td><td>{_noise_text(sensor)}</td></tr>"
            for sensor in self.sensors
        )
        return (
            f"<b>{self.name}</b><table><tr><th>state</th><th>unit</th><th>prior</th></tr>{rows}"
            f"</table><table><tr><th>sensor</th><th>kind</th><th>noise (std)</th></tr>{sensors}"
            "</table>"
        )


def additive_manifold(wrapped: Sequence[bool]) -> tuple[ca.Function, ca.Function]:
    """Return (retract, difference) of plain addition with wrapped angles.

    Parameters
    ----------
    wrapped : (n_x,), true where a component is an angle on the circle: it is
        then kept within [-π, π], and the difference is the short way round
    """
    x, delta = ca.SX.sym("x", len(wrapped)), ca.SX.sym("delta", len(wrapped))

    def wrap(vector: ca.SX) -> ca.SX:
        return ca.vertcat(
            *(
                ca.remainder(vector[i], 2 * ca.pi) if angle else vector[i]
                for i, angle in enumerate(wrapped)
            )
        )

    retract = ca.Function("retract", [x, delta], [wrap(x + delta)], ["x", "delta"], ["x_moved"])
    other = ca.SX.sym("other", len(wrapped))
    difference = ca.Function("difference", [x, other], [wrap(x - other)], ["to", "from"], ["delta"])
    return retract, difference


def no_inequality(n_x: int) -> ca.Function:
    """Return the inequality of a model that has none: (n_x,) -> (0,)."""
    x = ca.SX.sym("x", n_x)
    return ca.Function("inequality", [x], [ca.SX(0, 1)], ["x"], ["g"])


def always_regular(n_x: int) -> ca.Function:
    """Return the regularity of a model without singular coordinates: the constant 1."""
    x = ca.SX.sym("x", n_x)
    return ca.Function("regularity", [x], [ca.SX(1)], ["x"], ["margin"])


def _noise_text(sensor: SensorModel) -> str:
    """Return e.g. ``0.1 m/s² (3 rows), …``: equal neighbours together."""
    parts: list[str] = []
    for (std, unit), group in itertools.groupby(
        zip(sensor.noise_std, sensor.unit_of_row, strict=True)
    ):
        parts.append(f"{std:.3g} {unit} ({len(list(group))} rows)")
    return ", ".join(parts)


def _check_shapes(model: StateSpaceModel) -> None:
    n_x = model.n_x
    expected = {
        "state_units": (len(model.state_units), n_x),
        "f's state": (model.f.numel_in(0), n_x),
        "f's step": (model.f.numel_in(2), 1),
        "f's result": (model.f.numel_out(0), n_x),
        "prior mean": (model.prior.mean.size, n_x),
        "prior covariance": (model.prior.covariance.size, n_x * n_x),
        "lower": (model.lower.size, n_x),
        "upper": (model.upper.size, n_x),
        "retract": (model.retract.numel_out(0), n_x),
        "difference": (model.difference.numel_out(0), n_x),
        "inequality": (model.inequality.numel_in(0), n_x),
        "regularity": (model.regularity.numel_out(0), 1),
    }
    for sensor in model.sensors:
        expected[f"{sensor.name}: h"] = (sensor.h.numel_out(0), sensor.n_y)
        expected[f"{sensor.name}: residual"] = (sensor.residual.numel_out(0), sensor.n_r)
        expected[f"{sensor.name}: h's state"] = (sensor.h.numel_in(0), n_x)
        expected[f"{sensor.name}: residual's reading"] = (sensor.residual.numel_in(0), sensor.n_y)
        expected[f"{sensor.name}: residual's state"] = (sensor.residual.numel_in(1), n_x)
        expected[f"{sensor.name}: unit_of_axis"] = (len(sensor.unit_of_axis), sensor.n_y)
        expected[f"{sensor.name}: unit_of_row"] = (len(sensor.unit_of_row), sensor.n_r)
        if sensor.constant_reading is not None:
            size = sensor.constant_reading.size
            expected[f"{sensor.name}: constant_reading"] = (size, sensor.n_y)
    for what, (size, wanted) in expected.items():
        if size != wanted:
            raise InputError(f"model {model.name}: {what} has {size} entries, expected {wanted}")
    mean, covariance = model.prior.mean, model.prior.covariance
    for what, array, shape in (("mean", mean, (n_x,)), ("covariance", covariance, (n_x, n_x))):
        if array.shape != shape:
            raise InputError(
                f"model {model.name}: the prior {what} has shape {array.shape}, expected {shape}"
            )
        if not np.isfinite(array).all():
            raise InputError(
                f"model {model.name}: the prior {what} has entries that are not finite"
            )
    asymmetry = np.abs(covariance - covariance.T)
    if (asymmetry > 1e-9 * np.abs(covariance).max()).any():
        raise InputError(f"model {model.name}: the prior covariance is not symmetric")
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise InputError(
            f"model {model.name}: the prior covariance is not positive definite"
        ) from None
