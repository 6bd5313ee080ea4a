"""The unit of readings without one: from gravity, how fast it turns, and the Earth's field.

Of an accelerometer the median of |f| is near gravity in one unit, or in counts of one of the
common ranges. Of a gyroscope `recordings.turn_factor.turn_factor` fits how much faster its
rates are than gravity turns in the accelerometer of the same chip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.units import STANDARD_GRAVITY_M_S2
from recordings.foreign.header_units import KNOWN_UNITS, Unit
from recordings.plausible_units import LARGEST_RATE_RAD_S
from recordings.turn_factor import rough_turn, turn_factor

_DEG = math.pi / 180
ACCELERATION_UNITS = ("m_s2", "g", "mg", "cm_s2")
RATE_UNITS = ("rad_s", "deg_s", "mdeg_s")
WITHIN = 2.0
"""How far from gravity the median of |f| may lie, either way, in a unit."""
COUNTS_PER_G = (16384, 8192, 4096, 2048, 1024, 256, 64)
"""Of 16 bits at 2, 4, 8, 16 g; 1024 and 256 are common of older chips, 64 is of 8 bits at 2 g."""
COUNTS_WITHIN = 1.2
FIELDS, FIELD_WITHIN = ("ut", "gauss", "mgauss", "nt", "t"), 2.5
"""Units of magnetometers, and how far from the Earth's strength the median may lie in one."""
ONE_WITHIN = 1.6
"""How far from 1 it may lie in a normalised one: in gauss the Earth's is at most 0.66."""
COUNTS_PER_DEG_S = (131.0, 65.5, 32.8, 16.4)
"""Of 16 bits at 250, 500, 1000, 2000 deg/s, InvenSense's and Bosch's; the hand's own acceleration
hides the eighth by which ST's are fewer."""


@dataclass(frozen=True)
class FoundUnit:
    """A unit and what says it: ``(the median of its norm is 0.98)``."""

    unit: Unit
    why: str


LEAST_OF_FACTOR = 0.3
"""Part of a unit's factor that `RoughTurn.most` is at least: noise makes it less."""


def acceleration_unit(values: Array) -> FoundUnit | None:
    """Return the unit in which the median of |f| is gravity; None where there is none.

    Parameters
    ----------
    values : (n, 3) as they stand in the file
    """
    if (median := _median_norm(values)) <= 0:
        return None
    why = f"the median of its norm is {median:.4g}"
    ranked = sorted(
        (abs(math.log(median * KNOWN_UNITS[name].factor / STANDARD_GRAVITY_M_S2)), name)
        for name in ACCELERATION_UNITS[:3]
    )
    if ranked[0][0] <= math.log(WITHIN):
        return FoundUnit(KNOWN_UNITS[ranked[0][1]], why)
    counts = min(COUNTS_PER_G, key=lambda per_g: abs(math.log(median / per_g)))
    if abs(math.log(median / counts)) <= math.log(COUNTS_WITHIN):
        return FoundUnit(
            Unit(f"counts of 1/{counts} g", "m_s2", STANDARD_GRAVITY_M_S2 / counts), why
        )
    return None


def field_unit(values: Array, strength_ut: float, *, is_one: bool = False) -> FoundUnit | None:
    """Return the unit in which the median of a magnetic field's norm is nearest its strength.

    Iron in the pen may add as much again; units are ten times apart.

    Parameters
    ----------
    values : (n, 3) as they stand in the file
    is_one : whether the logger writes 1 for the Earth's field; then that is a unit, too
    """
    if (median := _median_norm(values)) <= 0:
        return None
    why = f"the median of its norm is {median:.4g}"
    if is_one and abs(math.log(median)) <= math.log(ONE_WITHIN):
        return FoundUnit(Unit("the Earth's field", "ut", strength_ut), why)
    off = {name: abs(math.log(median * KNOWN_UNITS[name].factor / strength_ut)) for name in FIELDS}
    best = min(off, key=lambda name: off[name])
    return FoundUnit(KNOWN_UNITS[best], why) if off[best] <= math.log(FIELD_WITHIN) else None


def rate_unit(
    rate_time_s: Array, rate: Array, force: tuple[Array, Array] | None, *, force_unit: str
) -> FoundUnit | None:
    """Return the unit of a gyroscope's rates.

    Parameters
    ----------
    rate_time_s, rate : (n,), (n, 3) as they stand in the file
    force : times (m,) and readings (m, 3) of an accelerometer with the same axes, where there is
        one
    force_unit : its unit: who writes g writes degrees
    """
    k = None
    if force is not None:
        for sign in (1.0, -1.0):
            k = k or turn_factor(*force, rate_time_s, sign * rate)
    of_counts = [
        Unit(f"counts of 1/{per:g} deg/s", "rad_s", _DEG / per) for per in COUNTS_PER_DEG_S
    ]
    units = [KNOWN_UNITS[name] for name in RATE_UNITS]
    if k is not None:
        if k < 0.003:  # counts, or thousandths of a degree
            units += of_counts
        best = min(units, key=lambda unit: abs(math.log(unit.factor / k)))
        more = "" if best not in of_counts else "; ST's sensors have an eighth fewer: give --units"
        return FoundUnit(best, f"gravity turns {k:.3g} rad for 1 of it{more}")
    known = np.abs(rate[np.isfinite(rate)])
    largest = float(np.quantile(known, 0.99)) if len(known) else 0.0
    in_counts = force_unit.startswith("counts")
    rough = None if force is None else rough_turn(*force, rate_time_s, rate)
    if rough is not None:
        most = rough.most
        if in_counts:
            nearest = min(of_counts, key=lambda unit: abs(math.log(unit.factor / most)))
            units = [*units[:-1], nearest]
        likely = next((u for u in units if u.factor * LEAST_OF_FACTOR <= most), units[-1])
        return FoundUnit(likely, f"gravity turns {most:.2g} rad at most for 1 of it")
    if in_counts:
        return FoundUnit(of_counts[0], "assumed, as the accelerometer is in counts")
    if largest > LARGEST_RATE_RAD_S:
        return FoundUnit(KNOWN_UNITS["deg_s"], f"rates of {largest:.3g} are beyond rad/s")
    if force_unit in ("g", "mg"):
        return FoundUnit(KNOWN_UNITS["deg_s"], "assumed, as the accelerometer is in g")
    return FoundUnit(KNOWN_UNITS["rad_s"], "assumed")


def _median_norm(values: Array) -> float:
    """Return the median length of readings (n, 3); 0 without any."""
    norms = np.linalg.norm(values, axis=1)
    norms = norms[np.isfinite(norms)]
    return float(np.median(norms)) if len(norms) else 0.0
