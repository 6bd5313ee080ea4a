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
STEEP = 5.0
"""Finest steps, or noises, by which readings jump into a plateau that is no slow turn."""


def check_clipping(looked: Looked) -> Iterator[Finding]:
    """Find readings at the end of a range, told by the pen file or seen as plateaus."""
    for name, sensor in looked.inertial.items():
        time_s, values = looked.raw[name]
        limit, unit = sensor.reading_limit, readable_unit(sensor.si_unit)
        at_end = np.zeros(len(values), dtype=bool)
        ends = []
        for axis, column in zip(sensor.axes, values.T, strict=True):
            told = limit is not None and np.abs(column).max() >= limit
            end = limit if told and limit is not None else _plateau(column)
            if end is not None:
                at_end |= np.abs(column) >= end
                ends.append(f"{axis} at {end:.4g} {unit}")
        if at_end.sum() < FEWEST:
            continue
        part = float(at_end.mean())
        known = limit is not None and np.abs(values).max() >= limit
        remedy = "set a larger range in the sensor" + (
            "; such readings are not used"
            if known
            else f", or say its end in the pen file: range_{sensor.si_unit} = "
            f"{np.abs(values).max():.6g}, then such readings are not used"
        )
        where = np.flatnonzero(at_end)
        yield Finding(
            f"{int(at_end.sum())} readings ({part:.2g} of all) are at the end of its range "
            f"({', '.join(ends)})",
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
