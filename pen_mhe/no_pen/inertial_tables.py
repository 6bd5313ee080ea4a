"""The tables of accelerometer and gyroscope in a pen file that is found in a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.sensor_kinds.inertial import InertialSensor, sample_noise_std
from models.units import UNITS, readable_unit
from pen_mhe.no_pen.at_rest import AtRest
from pen_mhe.no_pen.lines import ASSUMED, MEASURED, PenLine, rounded

BANDWIDTH = 0.5
"""Of the rate, where nothing says how a sensor filters."""
FEW_VALUES = 3.0
"""Readings per different value from which a sensor's step shows."""
LEAST_OF_STEP = 0.1
"""Of a step: the noise of a sensor whose reading hardly changes."""


@dataclass(frozen=True)
class UsualLevels:
    """What chips of a kind are like, in the unit that a pen file says it in.

    Parameters
    ----------
    unit : of `models.units.UNITS`
    noise_std : of a reading, where no rest shows it
    bias_std, bias_std_unknown : of the bias behind a rest, and without one
    bias_walk : per √s
    bias_shows : whether a rest shows the bias
    """

    unit: str
    noise_std: float
    bias_std: float
    bias_std_unknown: float
    bias_walk: float
    bias_shows: bool


USUAL: Mapping[str, UsualLevels] = MappingProxyType(
    {
        "m_s2": UsualLevels("mg", 4.0, 20.0, 30.0, 0.1, False),
        "rad_s": UsualLevels("deg_s", 0.15, 0.1, 3.0, 0.005, True),
    }
)
"""SI unit of a kind's readings → what its chips are like: consumer parts, as soldered."""


def inertial_table(
    name: str,
    sensor: InertialSensor,
    rate_hz: float,
    *,
    rest: AtRest | None,
    placed: Sequence[PenLine],
) -> list[PenLine]:
    """Return the table of one sensor.

    Parameters
    ----------
    sensor : by which it was read
    placed : where it sits, and how it is turned
    rest : what the recording shows; None where it is never still
    """
    usual = USUAL[sensor.si_unit]
    factor = UNITS[sensor.si_unit][usual.unit]
    bandwidth = BANDWIDTH * rate_hz
    noise, step, how = usual.noise_std * factor, 0.0, f"{usual.noise_std:g} {usual.unit} a reading"
    origin = ASSUMED
    if rest is not None:
        step = step_of(np.concatenate([still.readings[name] for still in rest.stills]))
        total = float(np.sqrt(np.mean(rest.noise_std(name) ** 2)))
        noise = max(math.sqrt(max(total**2 - step**2 / 12, 0.0)), LEAST_OF_STEP * step)
        noise = max(noise, 1e-3 * usual.noise_std * factor)
        unit = readable_unit(sensor.si_unit)
        how = f"a reading varies by {total:.3g} {unit} over {rest.duration_s:.2g} s of rest"
        origin = MEASURED
    density = noise / sample_noise_std(1.0, bandwidth)
    lines = [
        PenLine("kind", sensor.kind),
        PenLine("rate_hz", _short(rate_hz), MEASURED, "median interval"),
        PenLine("bandwidth_hz", _short(bandwidth), ASSUMED, "half of the rate"),
        PenLine(f"noise_density_{sensor.si_unit}_per_sqrt_hz", _short(density), origin, how),
    ]
    if step > 0:
        lines.append(PenLine(f"resolution_{sensor.si_unit}", _short(step), MEASURED, "its step"))
    return [*lines, *_bias_lines(name, rest, usual, factor), *placed]


def _bias_lines(name: str, rest: AtRest | None, usual: UsualLevels, factor: float) -> list[PenLine]:
    unit, std, why = usual.unit, usual.bias_std_unknown, "no rest shows it"
    lines, origin = [], ASSUMED
    if rest is not None and usual.bias_shows:
        bias = rounded(rest.rate_mean(name) / factor)
        lines = [PenLine(f"bias_{unit}", bias, MEASURED, "mean reading at rest")]
        std, why = usual.bias_std, "how it may differ from start to start, and drift"
    elif rest is not None:
        std, why = usual.bias_std, "a bias and a tilt look alike in one pose"
    return [
        *lines,
        PenLine(f"bias_std_{unit}", std, origin, why),
        PenLine(f"bias_walk_{unit}_per_sqrt_s", usual.bias_walk, ASSUMED, "a consumer part"),
    ]


def step_of(values: Array) -> float:
    """Return the step between readings (n, n_axes); 0 where it does not show."""
    steps = []
    for axis in values.T:
        different = np.unique(axis)
        if len(different) > 1 and len(axis) >= FEW_VALUES * len(different):
            apart = np.diff(different)
            steps.append(float(apart[apart > 1e-6 * np.abs(different).max()].min(initial=np.inf)))
    return max((step for step in steps if np.isfinite(step)), default=0.0)


def _short(value: float) -> float:
    return float(f"{value:.4g}")
