"""One sensor as functions of the state."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array, fixed, keep_arrays
from models.units import TIME_DIGITS

SATURATED_FRACTION = 0.999
"""A reading beyond this part of the range counts as being at its limit."""


def quantiser_variance(resolution: float) -> float:
    """Return the variance Δ²/12 of the uniform error of a quantiser of step Δ."""
    return resolution**2 / 12


@dataclass(frozen=True)
class RestRule:
    """When inertial readings say that a body rests; see `models.sensor_kinds.rest.Rest`.

    Parameters
    ----------
    window_s : how long it must have been still, s
    spread_factor : by how many times its noise a reading may spread
    largest_bias_rad_s : largest mean rate that may be bias; None follows from the prior's biases
    """

    window_s: float
    spread_factor: float
    largest_bias_rad_s: float | None = None


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One sensor as the estimators see it.

    Parameters
    ----------
    name : its name in the pen file
    kind : one of `models.sensor_kinds.table.SENSOR_KINDS`, for display only
    axes, unit_of_axis : the components of a reading y and their units
    h : casadi.Function (n_x,) -> (n_y,), the reading without noise
    residual : casadi.Function (n_y,), (n_x,) -> (n_r,), y "minus" h(x); its rows
        are in the unit of `noise_std`. Both may take the model's inputs (n_u,) behind the state
    noise_std, unit_of_row : (n_r,) standard deviation and unit of the residual's rows,
        the quantiser's error included
    rate_hz, delay_s : see `models.sensor_kinds.mounted.SensorBase`
    constant_reading : (n_y,) for a sensor without readings of its own, else None
    reading_limit : the range: no reading lies beyond ± this, in the reading's unit
    resolution : step of the quantiser, in the reading's unit; 0 has none
    touched_height : of a sensor that reads this height while the tip touches it, and
        nothing in the air; None for others
    seen : casadi.Function (n_x,) -> a number that is negative where there is no reading, for the
        simulator; None reads everywhere
    dropout_fraction, huber, gate_probability : see `models.sensor_kinds.mounted.SensorBase`; the
        last two are for whoever builds an estimator, see `losses`
    usual_innovations : see `models.sensor_kinds.mounted.SensorBase`; for a watch
    bias_states : names of the model's states that are this sensor's biases
    bias_walk : density of their random walk, the reading's unit per √s
    sees_pose, feels_gravity, reads_rate, is_disturbed : see
        `models.sensor_kinds.mounted.SensorBase`
    is_derived : whether its readings follow from those of others: they bring no noise of their
        own, and consistency leaves them out
    rest : of a sensor whose readings an estimator makes itself, zero while the body rests; None
        for others
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
    resolution: float = 0.0
    touched_height: float | None = None
    seen: ca.Function | None = None
    dropout_fraction: float = 0.0
    huber: float | None = None
    gate_probability: float | None = None
    usual_innovations: tuple[float, ...] | None = None
    bias_states: tuple[str, ...] = ()
    bias_walk: float = 0.0
    sees_pose: bool = False
    feels_gravity: bool = False
    reads_rate: bool = False
    is_disturbed: bool = False
    is_derived: bool = False
    rest: RestRule | None = None

    def __post_init__(self) -> None:
        keep_arrays(self)

    @property
    def reads_inputs(self) -> bool:
        """Whether what it reads depends on the model's inputs."""
        return int(self.residual.n_in()) > 2

    def inputs_of(self, inputs: Any) -> tuple[Any, ...]:
        """Return what `h` and `residual` take behind the state, of the model's inputs (n_u,)."""
        return (inputs,) if self.reads_inputs else ()

    @property
    def has_readings(self) -> bool:
        """Whether it has readings of its own, that somebody must give."""
        return self.constant_reading is None and self.rest is None

    @property
    def is_measured(self) -> bool:
        """Whether its rows are news with noise of their own."""
        return self.has_readings and not self.is_derived

    @property
    def n_y(self) -> int:
        """Number of components of a reading."""
        return len(self.axes)

    @property
    def n_r(self) -> int:
        """Number of rows of the residual."""
        return len(self.noise_std)

    @property
    def drawn_std(self) -> Array:
        """(n_r,) standard deviation of the noise before the quantiser: what a simulator draws."""
        drawn = self.noise_std**2 - quantiser_variance(self.resolution)
        return np.sqrt(np.maximum(drawn, 0.0))

    @property
    def saturation_limit(self) -> float:
        """|y| from which a reading counts as saturated; inf without a range.

        A little inside the range: the largest code of a converter lies a step
        below it, and data sheets round (32767 · 0.061 mg is 1.9988 g of ±2 g).
        """
        if self.reading_limit is None:
            return float("inf")
        return min(SATURATED_FRACTION * self.reading_limit, self.reading_limit - self.resolution)

    def first_of_each_period(
        self, time_s: Array, *, behind: tuple[float, float] | None = None
    ) -> NDArray[np.bool_]:
        """Return the instants (n,) that are the first in their period; all without a rate.

        Parameters
        ----------
        behind : first and last of the instants that these follow; None where they are the first
        """
        if self.rate_hz is None or len(time_s) == 0:
            return np.ones(len(time_s), dtype=bool)
        start_s = time_s[0] if behind is None else behind[0]
        time_s = time_s if behind is None else np.concatenate([behind[1:], time_s])
        # Seconds since 1970 resolve no nanoseconds. By each instant: none knows of later ones.
        resolution = np.maximum(0.5 * 10**-TIME_DIGITS, 2 * np.spacing(np.abs(time_s)))
        period = np.floor((time_s - start_s + resolution) * self.rate_hz)
        return np.diff(period, prepend=-1.0 if behind is None else []) > 0

    @cached_property
    def row_needs(self) -> NDArray[np.bool_]:
        """(n_r, n_y): which components of y each row of the residual depends on."""
        pattern = self.residual.sparsity_jac(0, 0)
        return fixed(np.array(ca.DM(pattern, 1).full() != 0))


LOSSES = ("huber", "gate_probability")
"""What a sensor says of its outliers, by the name of the setting that an estimator reads."""


def losses(sensors: Iterable[SensorModel]) -> dict[str, dict[str, float]]:
    """Return setting → sensor → value of what sensors say of their outliers; no empty ones."""
    said = {
        setting: {
            sensor.name: value
            for sensor in sensors
            if (value := getattr(sensor, setting)) is not None
        }
        for setting in LOSSES
    }
    return {setting: values for setting, values in said.items() if values}


def noise_text(sensor: SensorModel) -> str:
    """Return e.g. ``0.1 m/s² (3 rows), …``: equal neighbours together."""
    parts: list[str] = []
    for (std, unit), group in itertools.groupby(
        zip(sensor.noise_std, sensor.unit_of_row, strict=True)
    ):
        parts.append(f"{std:.3g} {unit} ({len(list(group))} rows)")
    return ", ".join(parts)
