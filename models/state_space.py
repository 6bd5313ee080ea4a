"""The state-space model: a frozen value that every estimator reads.

    x_{k+1} = f(x_k, w_k, Δt),   w ~ N(0, I)
    0 ≈ residual(y, x) ~ N(0, diag(noise_std²))

States may live on a manifold: ``retract(x, δ)`` moves a state by a tangent
vector, ``difference(a, b)`` is the tangent vector from b to a.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.errors import InputError
from models.feasibility import feasible
from models.gaussian import GaussianState
from models.model_checks import check_model
from models.names import did_you_mean, expected_one_of
from models.sensor_model import SensorModel, noise_text


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
    reach : (n_x,) standard deviation from which a state says nothing, inf where there is
        none; None for no such limit at all
    symmetries : casadi.Functions (n_x,), () -> (n_x,): changes of the state that some
        choice of sensors may not show; `estimation.symmetry` finds out whether it does
    conditions : (n_g, n_y) readings that an instant must have for a row of the inequality to
        be demanded; None demands every row always
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
    reach: Array | None = None
    symmetries: tuple[ca.Function, ...] = ()
    conditions: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        check_model(self)

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
    def inequality_needs(self) -> NDArray[np.bool_]:
        """(n_g, n_y): readings that an instant must have to demand a row of the inequality."""
        if self.conditions is None:
            return np.zeros((self.inequality.numel_out(0), self.n_y), dtype=bool)
        return self.conditions

    @cached_property
    def saturation(self) -> Array:
        """(n_y,) |y| from which a reading says only that its sensor is at its limit; inf: none."""
        return np.concatenate(
            [np.zeros(0), *(np.full(s.n_y, s.saturation_limit) for s in self.sensors)]
        )

    @cached_property
    def measured_rows(self) -> NDArray[np.bool_]:
        """(n_r,) which rows of the stacked residual come from readings, not from a constant."""
        return np.concatenate(
            [np.zeros(0, bool)] + [np.full(s.n_r, s.constant_reading is None) for s in self.sensors]
        )

    @cached_property
    def reading_names(self) -> tuple[str, ...]:
        """(n_y,) names of the stacked readings: ``accel_x``, …"""
        return tuple(f"{sensor.name}_{axis}" for sensor in self.sensors for axis in sensor.axes)

    @property
    def measured_sensors(self) -> tuple[SensorModel, ...]:
        """The sensors that have readings of their own; not the writing area."""
        return tuple(s for s in self.sensors if s.constant_reading is None)

    def sensor(self, name: str) -> SensorModel:
        """Return a sensor by name; raises `InputError` for an unknown one."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        known = [sensor.name for sensor in self.sensors]
        raise InputError(
            f"sensor {name} is not part of the model {self.name}; "
            f"expected {', '.join(known)}{did_you_mean(name, known)}"
        )

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
                    f"model {self.name}: bound on unknown state {state}; "
                    f"{expected_one_of(state, self.state_names)}"
                )
            if not low < high:
                raise InputError(
                    f"model {self.name}: bound on {state}: lower {low} is not below upper {high}, "
                    "expected lower < upper"
                )
            index = self.state_names.index(state)
            lower[index], upper[index] = low, high
        return feasible(self.replace(lower=lower, upper=upper))

    def constrained(
        self, inequality: Callable[[ca.SX], ca.SX], needs: Iterable[str] | None = None
    ) -> StateSpaceModel:
        """Return a copy that also demands ``inequality(x) <= 0``, row by row.

        Parameters
        ----------
        inequality : takes the symbolic state (n_x,) and returns (n_g,) expressions
        needs : names of readings, as of `reading_names`: only an instant that has all of
            them demands these rows; every instant does without any

        Raises
        ------
        InputError
            If a reading is unknown, or no state meets the affine rows and the bounds that
            some instant demands; see `models.feasibility`.
        """
        x = ca.SX.sym("x", self.n_x)
        added = ca.vertcat(inequality(x))
        rows = ca.vertcat(self.inequality(x), added)
        g = ca.Function("inequality", [x], [rows], ["x"], ["g"])
        needed = self._needed(needs)
        conditions = self.conditions
        if conditions is not None or needed.any():
            of_added = np.tile(needed, (added.numel(), 1))
            conditions = np.vstack([self.inequality_needs, of_added])
        return feasible(self.replace(inequality=g, conditions=conditions))

    def _needed(self, readings: Iterable[str] | None) -> NDArray[np.bool_]:
        """Return (n_y,) which of the stacked readings are named; none for None."""
        names = (readings,) if isinstance(readings, str) else tuple(readings or ())
        for name in names:
            if name not in self.reading_names:
                raise InputError(
                    f"model {self.name}: an inequality needs the unknown reading {name}; "
                    f"{expected_one_of(name, self.reading_names)}"
                )
        return np.isin(self.reading_names, names)

    def __repr__(self) -> str:
        lines = [f"StateSpaceModel {self.name}: {self.n_x} states, {self.n_w} noises"]
        for name, mean, std in zip(self.state_names, self.prior.mean, self.prior.std, strict=True):
            lines.append(f"  {name:32s} prior {mean:10.4g} ± {std:.4g}")
        for sensor in self.sensors:
            rate = f"{sensor.rate_hz:g} Hz" if sensor.rate_hz else "as recorded"
            noise = noise_text(sensor)
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
            f"<tr><td>{sensor.name}</td><td>{sensor.kind}</td><td>{noise_text(sensor)}</td></tr>"
            for sensor in self.sensors
        )
        return (
            f"<b>{self.name}</b><table><tr><th>state</th><th>unit</th><th>prior</th></tr>{rows}"
            f"</table><table><tr><th>sensor</th><th>kind</th><th>noise (std)</th></tr>{sensors}"
            "</table>"
        )
