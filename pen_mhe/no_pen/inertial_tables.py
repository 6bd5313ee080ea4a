"""The tables of accelerometer and gyroscope in a pen file that is found in a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.sensor_kinds.inertial import InertialSensor, sample_noise_std
from models.units import UNITS
from pen_mhe.no_pen.at_rest import AtRest
from pen_mhe.no_pen.lines import ASSUMED, MEASURED, PenLine, rounded
from pen_mhe.no_pen.noise_found import NoiseFound, noise_found

BANDWIDTH = 0.5
"""Of the rate, where nothing says how a sensor filters."""


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
    readings: tuple[Array, Array],
    *,
    rest: AtRest | None,
    placed: Sequence[PenLine],
) -> tuple[list[PenLine], NoiseFound]:
    """Return the table of one sensor, and its noise.

    Parameters
    ----------
    sensor : by which it was read
    readings : its times (n,) and readings (n, n_axes)
    rest : what the recording shows; None where it is never still
    placed : where it sits, and how it is turned
    """
    usual = USUAL[sensor.si_unit]
    factor = UNITS[sensor.si_unit][usual.unit]
    noise = noise_found(name, sensor.si_unit, readings, rest, usual.noise_std * factor)
    rate = rate_hz(readings[0])
    bandwidth = BANDWIDTH * rate
    density = _short(noise.std / sample_noise_std(1.0, bandwidth))
    lines = [
        PenLine("kind", sensor.kind),
        PenLine("rate_hz", _short(rate), MEASURED, "median interval"),
        PenLine("bandwidth_hz", _short(bandwidth), ASSUMED, "half of the rate"),
        PenLine(f"noise_density_{sensor.si_unit}_per_sqrt_hz", density, noise.origin, noise.why),
    ]
    if noise.step > 0:
        step = PenLine(f"resolution_{sensor.si_unit}", _short(noise.step), MEASURED, "its step")
        lines.append(step)
    return [*lines, *_bias_lines(name, rest, usual, factor), *placed], noise


def rate_hz(time_s: Array) -> float:
    """Return the rate of stamps (n,)."""
    return 1 / float(np.median(np.diff(time_s))) if len(time_s) > 1 else 1.0


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


def _short(value: float) -> float:
    return float(f"{value:.4g}")
