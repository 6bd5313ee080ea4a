"""Check: does a sensor reach the end of its range?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from models.units import readable_unit
from recordings.checks.looked import Looked
from recordings.checks.repeats import noise_of_steps
from recordings.finding import Finding, Severity

MOST = 0.1
"""Part of the readings at an end from which on an estimate cannot be meant."""
FEWEST, PLATEAUS = 4, 2
"""Readings at an end, and plateaus of them."""
BEYOND = 1.02
"""Times its range that readings of a sensor can not have."""
STEEP = 5.0
"""Finest steps, or noises, by which readings jump into a plateau that is no slow turn."""


def check_clipping(looked: Looked) -> Iterator[Finding]:
    """Find readings at the end of a range, told by the pen file or seen as plateaus."""
    for name, sensor in looked.inertial.items():
        time_s, values = looked.raw[name]
        limit, unit = sensor.reading_limit, readable_unit(sensor.si_unit)
        largest = float(np.abs(values).max())
        ends = np.full(values.shape[1], np.inf)
        if limit is not None and largest >= limit:
            ends[:] = limit
        else:
            for i, column in enumerate(values.T):
                ends[i] = _plateau(column) or np.inf
        at_end = (np.abs(values) >= ends).any(axis=1)
        if at_end.sum() < FEWEST:
            continue
        part, where = float(at_end.mean()), np.flatnonzero(at_end)
        of_all = f"{int(at_end.sum())} readings, {part:.2g} of all,"
        key = f"range_{sensor.si_unit}"
        if limit is not None and largest > BEYOND * limit:
            what = f"{of_all} are beyond its range in the pen file, {limit:.4g} {unit}"
            remedy = f"they are not used; if its range is larger, say so there: {key}"
        elif limit is not None and largest >= limit:
            what = f"{of_all} are at the end of its range, {limit:.4g} {unit}"
            remedy = "they are not used; set a larger range in the sensor"
        else:
            axes = [axis for axis, end in zip(sensor.axes, ends, strict=True) if np.isfinite(end)]
            what = f"{of_all} are cut off at {largest:.4g} {unit}, on {' and '.join(axes)}"
            remedy = (
                "set a larger range in the sensor, or let such readings out by its range in the "
                f"pen file: {key} = {0.999 * largest:.5g}"
            )
        yield Finding(
            what,
            name,
            0.95,
            remedy,
            Severity.NOT_MEANT if part > MOST else Severity.REMARK,
            (float(time_s[where[0]]), float(time_s[where[-1]])),
        )


def _plateau(column: Array) -> float | None:
    """Return the size at which readings are cut off; None where they are not."""
    end = float(np.abs(column).max())
    flat = np.abs(column) >= end
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]]))).reshape(-1, 2)
    finest, noise = (float(part[0]) for part in noise_of_steps(column[:, None]))
    steep = STEEP * max(noise, finest if np.isfinite(finest) else 0.0)
    plateaus = [
        (a, b)
        for a, b in edges
        if b - a >= 2 and a > 0 and b < len(column)
        and min(end - abs(column[a - 1]), end - abs(column[b])) > steep
    ]  # fmt: skip
    return end if len(plateaus) >= PLATEAUS and flat.sum() >= FEWEST else None
