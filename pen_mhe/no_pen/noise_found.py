"""The noise of a reading, by what a recording shows at rest and by how its stamps jitter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.units import readable_unit
from pen_mhe.no_pen.at_rest import AtRest
from pen_mhe.no_pen.lines import ASSUMED, MEASURED
from pen_mhe.no_pen.stamps import jitter_noise, stamp_jitter_s

FEW_VALUES = 3.0
"""Readings per different value from which a sensor's step shows."""
LEAST_OF_STEP = 0.1
"""Of a step: the noise of a sensor whose reading hardly changes."""
LEAST_OF_USUAL = 1e-3
"""Of the noise that is usual: that of one whose reading never changes."""


@dataclass(frozen=True)
class NoiseFound:
    """The noise of a sensor's reading, SI.

    Parameters
    ----------
    std : by the sensor and by the jitter of stamps, beside its step
    own_std : by the sensor alone
    step : between readings, 0 where it does not show
    origin, why : as in the pen file
    """

    std: float
    own_std: float
    step: float
    origin: str
    why: str


def noise_found(
    name: str, si_unit: str, readings: tuple[Array, Array], rest: AtRest | None, usual_std: float
) -> NoiseFound:
    """Return the noise of a sensor.

    Parameters
    ----------
    readings : its times (n,) and readings (n, n_axes)
    rest : what the recording shows; None where it is never still
    usual_std : what is assumed where no rest shows it, SI
    """
    unit = readable_unit(si_unit)
    own, step, origin, why = usual_std, 0.0, ASSUMED, f"{usual_std:.2g} {unit} a reading"
    if rest is not None:
        step = step_of(np.concatenate([still.readings[name] for still in rest.stills]))
        total = float(np.sqrt(np.mean(rest.noise_std(name) ** 2)))
        own = math.sqrt(max(total**2 - step**2 / 12, 0.0))
        own = max(own, LEAST_OF_STEP * step, LEAST_OF_USUAL * usual_std)
        why = f"a reading varies by {total:.3g} {unit} over {rest.duration_s:.2g} s of rest"
        origin = MEASURED
    more = jitter_noise(*readings)
    if more > own:
        jitter_ms = 1e3 * stamp_jitter_s(readings[0])
        why += f"; stamps jitter by {jitter_ms:.2g} ms, which adds {more:.2g} {unit} in motion"
    return NoiseFound(math.hypot(own, more), own, step, origin, why)


def step_of(values: Array) -> float:
    """Return the step between readings (n, n_axes); 0 where it does not show."""
    steps = []
    for axis in values.T:
        different = np.unique(axis)
        if len(different) > 1 and len(axis) >= FEW_VALUES * len(different):
            apart = np.diff(different)
            steps.append(float(apart[apart > 1e-6 * np.abs(different).max()].min(initial=np.inf)))
    return max((step for step in steps if np.isfinite(step)), default=0.0)
