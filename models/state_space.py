"""The state-space model: a frozen value that every estimator reads.

    x_{k+1} = f(x_k, w_k, Δt, u_k, u_{k+1}),   w ~ N(0, I)
    0 ≈ residual(y, x, u) ~ N(0, diag(noise_std²))

with known inputs u where a model has some: those at both ends of the step, so that f says
whether they are held or interpolated. They stand behind an instant's stacked readings.
States may live on a manifold: ``retract(x, δ)`` moves a state by a tangent
vector, ``difference(a, b)`` is the tangent vector from b to a.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array, fixed, keep_arrays
from models.bounds import split_bounds
from models.errors import InputError
from models.feasibility import feasible
from models.gaussian import GaussianState
from models.model_checks import check_needs
from models.model_text import model_html, model_text
from models.names import did_you_mean, several
from models.outputs import Outputs, TangentNames
from models.sensor_model import SensorModel
from models.state_space_parts import check_model, stacked_row, with_rows


@dataclass(frozen=True, eq=False)
class StateSpaceModel:
    """A model of motion with its sensors; see the module's equations.

    Parameters
    ----------
    name : for people
    state_names : (n_x,) names that end in their unit
    f : casadi.Function (n_x,), (n_w,), () -> (n_x,); Δt in seconds is the last argument, but for
        (n_u,), (n_u,), the inputs at the step's beginning and end, of a model that has inputs
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
    outputs : what people read of a state; None where they read the state
    tangent : tangent vectors in words of motions; None where the state's names do
    input_names, input_units : (n_u,) of the known inputs, in their order; none for most models
    interval_s : of a model that is defined over whole numbers of it only: f is NaN between; None
        for any step
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
    outputs: Outputs | None = None
    tangent: TangentNames | None = None
    input_names: tuple[str, ...] = ()
    input_units: tuple[str, ...] = ()
    interval_s: float | None = None

    def __post_init__(self) -> None:
        check_model(self)
        keep_arrays(self)
        keep_arrays(prior := copy(self.prior))
        object.__setattr__(self, "prior", prior)

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
    def n_u(self) -> int:
        """Number of known inputs."""
        return len(self.input_names)

    @property
    def n_row(self) -> int:
        """Number of an instant's numbers: stacked readings, and its inputs behind them."""
        return self.n_y + self.n_u

    @property
    def n_r(self) -> int:
        """Number of rows of all residuals stacked."""
        return sum(sensor.n_r for sensor in self.sensors)

    @cached_property
    def noise_std(self) -> Array:
        """(n_r,) standard deviations of the stacked residual."""
        return fixed(np.concatenate([np.zeros(0), *(s.noise_std for s in self.sensors)]))

    @cached_property
    def row_needs(self) -> NDArray[np.bool_]:
        """(n_r, n_y): which components of y each row of the stacked residual needs."""
        needs = np.zeros((self.n_r, self.n_y), dtype=bool)
        row = column = 0
        for sensor in self.sensors:
            needs[row : row + sensor.n_r, column : column + sensor.n_y] = sensor.row_needs
            row, column = row + sensor.n_r, column + sensor.n_y
        return fixed(needs)

    @cached_property
    def inequality_needs(self) -> NDArray[np.bool_]:
        """(n_g, n_y): readings that an instant must have to demand a row of the inequality."""
        if self.conditions is None:
            return fixed(np.zeros((self.inequality.numel_out(0), self.n_y), dtype=bool))
        return self.conditions

    @cached_property
    def saturation(self) -> Array:
        """(n_y,) |y| from which a reading says only that its sensor is at its limit; inf: none."""
        limits = (np.full(s.n_y, s.saturation_limit) for s in self.sensors)
        return fixed(np.concatenate([np.zeros(0), *limits]))

    @cached_property
    def measured_rows(self) -> NDArray[np.bool_]:
        """(n_r,) which rows come from readings: not of a constant, nor what others say (rest)."""
        measured = (np.full(s.n_r, s.is_measured) for s in self.sensors)
        return fixed(np.concatenate([np.zeros(0, bool), *measured]))

    @cached_property
    def reading_names(self) -> tuple[str, ...]:
        """(n_y,) names of the stacked readings: ``accel_x``, …"""
        return tuple(f"{sensor.name}_{axis}" for sensor in self.sensors for axis in sensor.axes)

    @property
    def measured_sensors(self) -> tuple[SensorModel, ...]:
        """The sensors that have readings of their own; not the writing area, nor detected rest."""
        return tuple(s for s in self.sensors if s.has_readings)

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

    def step_inputs(self, row: Any, next_row: Any) -> tuple[Any, ...]:
        """Return what f takes behind Δt, from the rows (n_row,) at both ends of a step."""
        return (row[self.n_y :], next_row[self.n_y :]) if self.n_u else ()

    def stack(
        self, readings: Mapping[str, Array], inputs: Mapping[str, float] | None = None
    ) -> Array:
        """Stack readings by sensor name, and inputs behind them, into one row (n_row,).

        NaN stands where there is none: a reading is missing then, an input as it was before.

        Raises
        ------
        InputError
            If a reading has another shape, or a sensor or an input is unknown.
        """
        return stacked_row(self, readings, inputs or {})

    def replace(self, **changes: object) -> StateSpaceModel:
        """Return a copy with some fields changed."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def bounded(self, **bounds: tuple[float, float]) -> StateSpaceModel:
        """Return a copy with (lower, upper) bounds on states given by name.

        Bounds on an output that is no state (a pen's elevation) are inequalities.

        Raises
        ------
        InputError
            If a name is unknown, a bound is empty, or no state meets them all.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        rows = split_bounds(self, bounds, lower=lower, upper=upper)
        model = feasible(self.replace(lower=lower, upper=upper))
        for row in rows:
            model = model.constrained(row)
        return model

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
            If it is no such function, a reading is unknown, or no state meets the affine rows and
            the bounds that some instant demands; see `models.feasibility`.
        """
        g, names = with_rows(self, inequality), several(needs or ())
        check_needs(self.name, self.reading_names, names)
        needed, conditions = np.isin(self.reading_names, names), self.conditions
        if conditions is not None or needed.any():
            n_added = g.numel_out(0) - self.inequality.numel_out(0)
            conditions = np.vstack([self.inequality_needs, np.tile(needed, (n_added, 1))])
        return feasible(self.replace(inequality=g, conditions=conditions))

    def __repr__(self) -> str:
        return model_text(self)

    def _repr_html_(self) -> str:
        return model_html(self)
