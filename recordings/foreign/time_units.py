"""The unit of stamps: an epoch of this century, or a rate of inertial sensors near 100 Hz."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.errors import InputError
from recordings.foreign.header_units import KNOWN_UNITS, Unit, words_of
from recordings.foreign.stamped_cells import Stamped

SLOWEST_HZ, FASTEST_HZ = 4.0, 20_000.0
"""Rates of an inertial sensor that follows a hand."""
USUAL_HZ = 100.0
FINE: Mapping[str, tuple[str, ...]] = MappingProxyType({"sampletimefine": ("100us",)})
"""Header → more units that it may be in: Xsens' MTi counts tenths of a millisecond."""
CANDIDATES = ("s", "ms", "us", "100ns", "ns")
"""Units of stamps without one, of several alike the first counts."""
EPOCHS_S: Mapping[str, float] = MappingProxyType(
    {"1970-01-01": 0.0, "1601-01-01": 11_644_473_600.0, "0001-01-01": 62_135_596_800.0}
)
"""Day from which clocks count → seconds from it to 1970."""
CENTURY_S = (946_684_800.0, 4_102_444_800.0)
"""2000 to 2100, from 1970."""
_RATE = re.compile(
    r"(?:(?:update|sampl\w*|output|data|frame)[ _]*(?:rate|freq\w*)\D{0,20}?"
    r"|^(?:Trajectories|Segments|Joints|Model Outputs|Devices)\s*$\s*)(\d+(?:[.,]\d+)?)",
    re.IGNORECASE | re.MULTILINE,
)


def check_time_unit(header: str, unit: Unit, time_s: Array, where: str) -> None:
    """Refuse times in a unit in which no inertial sensor is so slow or fast, and another would do.

    Parameters
    ----------
    header, unit : of the column of stamps
    time_s : (n,) of the readings of an inertial sensor, converted from that unit

    Raises
    ------
    InputError
        The message names the unit that they look like.
    """
    if _mostly_usual(time_s):
        return
    step_s = usual_step(time_s)
    if step_s is None or 1 / FASTEST_HZ <= step_s <= 1 / SLOWEST_HZ:
        return
    step = step_s / unit.factor
    likely = [
        name for name in CANDIDATES
        if 1 / FASTEST_HZ <= step * KNOWN_UNITS[name].factor <= 1 / SLOWEST_HZ
    ]  # fmt: skip
    if likely:
        best = min(likely, key=lambda name: _off(step * KNOWN_UNITS[name].factor))
        raise InputError(
            f"{where}: column {header} was read in {unit.name} but looks like {best} "
            f"({1 / step_s:.3g} readings a second), expected --units time={best}"
        )


def _mostly_usual(time_s: Array) -> bool:
    """Whether more than half of the steps are usual ones; then so is their median, unsorted."""
    steps = np.diff(time_s)
    usual = (steps >= 1 / FASTEST_HZ) & (steps <= 1 / SLOWEST_HZ)
    return 2 * int(np.count_nonzero(usual)) > len(steps)


def preamble_rate_hz(preamble: str) -> float | None:
    """Return the rate that the lines above a header give, as Xsens' ``// Update Rate: 100.0Hz``.

    Vicon's Nexus has it alone below the name of what it exports.
    """
    found = _RATE.search(preamble)
    return None if found is None else float(found[1].replace(",", ".")) or None


def found_unit(name: str, raw: Stamped, rate_hz: float | None) -> Unit:
    """Return the unit of stamps that have none written.

    Parameters
    ----------
    name : of their column
    raw : (n,) as they stand in the file
    rate_hz : that stands above the header, where one does
    """
    known = raw[np.isfinite(raw)]
    step = usual_step(np.asarray(known, dtype=float))
    first = float(known[0]) if len(known) else 0.0
    names = CANDIDATES + FINE.get("".join(words_of(name)), ())
    if "ticks" in words_of(name):
        names = ("100ns", "us", "ms")
    candidates = [KNOWN_UNITS[one] for one in names]
    if step is None:
        return candidates[0]
    for unit in candidates:
        since_s = [first * unit.factor - before_s for before_s in EPOCHS_S.values()]
        of_century = any(CENTURY_S[0] < one < CENTURY_S[1] for one in since_s)
        if of_century and step * unit.factor <= 10 / SLOWEST_HZ:
            return unit
    if rate_hz is not None:
        return min(candidates, key=lambda unit: abs(np.log(step * unit.factor * rate_hz)))
    return min(candidates, key=lambda unit: _off(step * unit.factor))


def _off(step_s: float) -> float:
    """Return how far a step is from a usual one; twice as far where no sensor has it."""
    off = abs(np.log(step_s * USUAL_HZ))
    return float(off if 1 / FASTEST_HZ <= step_s <= 1 / SLOWEST_HZ else 2 * off + 10)


def usual_step(values: Array) -> float | None:
    """Return the median of the steps forward; None where there is none."""
    steps = np.diff(values)
    if len(steps) and steps.min() > 0 and np.isfinite(steps.max()):  # NaN is not
        return float(np.median(steps))
    steps = np.diff(values[np.isfinite(values)])
    forward = steps[steps > 0]
    return float(np.median(forward)) if len(forward) else None
