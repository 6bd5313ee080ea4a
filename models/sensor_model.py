"""One sensor as functions of the state."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from models.arrays import Array


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


def noise_text(sensor: SensorModel) -> str:
    """Return e.g. ``0.1 m/s² (3 rows), …``: equal neighbours together."""
    parts: list[str] = []
    for (std, unit), group in itertools.groupby(
        zip(sensor.noise_std, sensor.unit_of_row, strict=True)
    ):
        parts.append(f"{std:.3g} {unit} ({len(list(group))} rows)")
    return ", ".join(parts)
