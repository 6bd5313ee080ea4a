"""Still stretches of a recording, found by how quiet its inertial sensors are.

A recording is cut into blocks of `BLOCK_S`. A block is still if every axis spreads by at most
`LOUDER` of what that axis does in the quietest tenth of the blocks, which may not be louder than
`PLAUSIBLE` of the noise that the pen file tells, and if it does so from reading to reading, as
noise does and a hand does not. Neighbouring still blocks are a stretch. A stretch in which the
mean force creeps, or whose mean rate differs from that of the others, is left out: it moves too
slowly for its spread to show. (No reading tells a steady turn about the vertical throughout a
recording from bias, below `LARGEST_BIAS_RAD_S`.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.sensor_kinds.inertial import InertialSensor
from models.units import readable_unit
from pen_mhe.calibration.given import complete_readings

BLOCK_S = 0.5
"""Longer blocks miss short stills, shorter ones know their spread less well."""
FEWEST = 8
"""Readings of each axis in a block."""
GAP = 4.0
"""Median intervals between readings beyond which a block has a gap and is not still."""
QUIET = 0.1
"""Part of the blocks that says how quiet an axis can be."""
LOUDER = 2.0
"""Times the quiet spread; larger takes more trembling for rest."""
PLAUSIBLE = 20.0
"""Times the noise in the pen file; larger trusts the file less."""
ABRUPT = 0.2
"""Mean square of successive differences over twice the variance: 1 for white noise, 0.5 and 0.3
behind a pole at a tenth and a twentieth of the rate, 0.05 for a hand at a twentieth."""
ROUNDING = 1e-6
"""Of the noise in the pen file: what a mean of equal readings leaves."""
MARGIN_S = 0.1
"""Left out at both ends of a stretch."""
SHORTEST_S = 1.0
"""Of a stretch without its margins."""
HALVES = 5.0
"""Standard errors by which the means of a stretch's halves differ at least if it creeps …"""
CREEP_M_S3 = 1e-3
"""… and at least so fast: gravity turns by 0.006 °/s."""
TURN_RAD_S = np.radians(0.5)
"""By which a stretch's mean rate may differ from the median of all."""
LARGEST_BIAS_RAD_S = np.radians(30.0)
"""A mean rate beyond this is a turn."""


@dataclass(frozen=True, eq=False)
class Still:
    """A stretch of a recording without motion.

    Parameters
    ----------
    recording : its name
    start_s, stop_s : in its time
    readings : sensor → (n, n_axes), complete rows, SI
    rate_hz : sensor → readings per second
    """

    recording: str
    start_s: float
    stop_s: float
    readings: Mapping[str, Array]
    rate_hz: Mapping[str, float]

    @property
    def duration_s(self) -> float:
        """How long it is, s."""
        return self.stop_s - self.start_s

    def mean(self, sensor: str) -> Array:
        """Return the mean reading (n_axes,)."""
        return np.asarray(self.readings[sensor].mean(axis=0))


@dataclass(frozen=True, eq=False)
class Stills:
    """What was found.

    Parameters
    ----------
    kept : in the order of time
    creeping, turning : left out, and why
    """

    kept: tuple[Still, ...]
    creeping: tuple[Still, ...]
    turning: tuple[Still, ...]


def find_stills(
    recordings: Sequence[Recording],
    sensors: Mapping[str, InertialSensor],
    *,
    quiet: float = QUIET,
) -> Stills:
    """Return the still stretches of recordings that have all of some sensors.

    Parameters
    ----------
    quiet : part of a recording's blocks that says how quiet an axis can be; smaller finds a short
        rest in a long recording, and takes chance for quiet sooner

    Raises
    ------
    InputError
        If a recording is never quiet, or whatever is quiet moves slowly.
    """
    candidates = [still for each in recordings for still in _quiet_stretches(each, sensors, quiet)]
    creeping = tuple(still for still in candidates if _creeps(still, sensors))
    rest = [still for still in candidates if still not in creeping]
    turning = tuple(still for still in rest if _turns(still, rest, sensors))
    kept = tuple(still for still in rest if still not in turning)
    if not kept:
        moves = candidates[0]
        how = "force creeps" if moves in creeping else "rate is no bias, or not that of others"
        raise InputError(
            f"recording {moves.recording} moves slowly from {moves.start_s:.4g} s to "
            f"{moves.stop_s:.4g} s, its mean {how}; expected a stretch that is still"
        )
    return Stills(kept, creeping, turning)


def _quiet_stretches(
    recording: Recording, sensors: Mapping[str, InertialSensor], quiet: float
) -> list[Still]:
    """Return the stretches whose blocks are quiet, without margins.

    Raises
    ------
    InputError
        If there are none.
    """
    start, step = recording.time_s[0], float(np.median(np.diff(recording.time_s)))
    n = max(int((recording.time_s[-1] + step - start) / BLOCK_S + 1e-9), 1)
    still = np.ones(n, dtype=bool)
    for name, sensor in sensors.items():
        times, values = complete_readings(recording, name)
        still &= _quiet_blocks(recording.name, name, sensor, times - start, values, n, part=quiet)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]]))).reshape(-1, 2)
    found = []
    for first, end in start + BLOCK_S * ends + [MARGIN_S, -MARGIN_S]:
        if end - first >= SHORTEST_S - 1e-9:
            found.append(_stretch(recording, sensors, float(first), float(end)))
    if not found:
        longest = max((BLOCK_S * int(b - a) for a, b in ends), default=0.0)
        raise InputError(
            f"recording {recording.name} has no still stretch of {SHORTEST_S + 2 * MARGIN_S:g} s, "
            f"the longest is {longest:g} s; expected the sensors held still"
        )
    return found


def _quiet_blocks(
    recording: str,
    name: str,
    sensor: InertialSensor,
    since_s: Array,
    values: Array,
    n: int,
    *,
    part: float,
) -> NDArray[np.bool_]:
    """Return which of n blocks are quiet (n,) by one sensor.

    Raises
    ------
    InputError
        If even the quietest blocks are far louder than the pen file's noise.
    """
    block = (since_s // BLOCK_S).astype(int)
    longest = GAP * float(np.median(np.diff(since_s))) if len(since_s) > 1 else 0.0
    limit, told, unit = sensor.reading_limit, sensor.sample_std, readable_unit(sensor.si_unit)
    spread = np.full((n, values.shape[1]), np.inf)
    is_abrupt = np.zeros(n, dtype=bool)
    for i in range(n):
        inside = slice(*np.searchsorted(block, [i, i + 1]))
        at, here = since_s[inside], values[inside]
        has_gap = np.diff(at, prepend=i * BLOCK_S, append=(i + 1) * BLOCK_S).max() > longest
        if len(here) < FEWEST or has_gap or (limit is not None and np.abs(here).max() >= limit):
            continue
        spread[i] = here.std(axis=0, ddof=1)
        steps = np.mean(np.diff(here, axis=0) ** 2, axis=0) / 2
        is_fine = spread[i] < max(sensor.resolution, told / PLAUSIBLE)
        is_abrupt[i] = (is_fine | (steps >= ABRUPT * spread[i] ** 2)).all()
    # Blocks that never change are of a stuck sensor, or its rests where no other block is quiet.
    quietest = partial(np.quantile, q=part, axis=0, method="lower")
    alive = quietest(np.where(spread > told * ROUNDING, spread, np.inf))
    found = np.where(alive <= PLAUSIBLE * told, alive, quietest(spread))
    quiet = np.maximum(found, told / PLAUSIBLE)
    loudest = int(np.argmax(quiet))
    if not quiet[loudest] <= PLAUSIBLE * told:
        said = f"spreads by {quiet[loudest]:.3g}" if np.isfinite(quiet[loudest]) else "has gaps"
        raise InputError(
            f"recording {recording} is never still: in its quietest tenth {name} "
            f"{sensor.axes[loudest]} {said} {unit} in {BLOCK_S:g} s, expected at most "
            f"{PLAUSIBLE:g} times the pen file's noise, {told:.3g} {unit}"
        )
    return is_abrupt & (spread <= LOUDER * quiet).all(axis=1)


def _stretch(
    recording: Recording, sensors: Mapping[str, InertialSensor], start_s: float, stop_s: float
) -> Still:
    readings, rates = {}, {}
    for name in sensors:
        times, values = complete_readings(recording, name)
        inside = slice(*np.searchsorted(times, [start_s, stop_s]))
        readings[name] = values[inside]
        rates[name] = 1 / float(np.median(np.diff(times[inside])))
    return Still(recording.name, start_s, stop_s, readings, rates)


def _creeps(still: Still, sensors: Mapping[str, InertialSensor]) -> bool:
    """Whether a force that is felt changes from half to half by more than noise and walk."""
    for name, sensor in ((n, sensor) for n, sensor in sensors.items() if sensor.feels_gravity):
        values = still.readings[name]
        halves = np.array_split(values, 2)
        change = np.abs(halves[1].mean(axis=0) - halves[0].mean(axis=0))
        walked = sensor.bias_walk**2 * still.duration_s / 3  # between means of halves
        error = np.sqrt(4 * values.var(axis=0, ddof=1) / len(values) + walked)
        if ((change > HALVES * error) & (change > CREEP_M_S3 * still.duration_s / 2)).any():
            return True
    return False


def _turns(still: Still, others: Sequence[Still], sensors: Mapping[str, InertialSensor]) -> bool:
    """Whether a rate differs from the median over all stretches, or is no bias at all."""
    for name in (name for name, sensor in sensors.items() if sensor.reads_rate):
        usual = np.median([other.mean(name) for other in others], axis=0)
        mean = still.mean(name)
        if (np.abs(mean - usual) > TURN_RAD_S).any() or np.linalg.norm(mean) > LARGEST_BIAS_RAD_S:
            return True
    return False
