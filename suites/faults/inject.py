"""Faults done to a recording: readings and stamps, nothing else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from suites.faults.beyond_readings import BEYOND_READINGS
from suites.faults.given_rows import GivenRows
from suites.faults.inject_readings import READINGS, HitReadings, swapped
from suites.faults.protocol import targets_of
from suites.faults.table import INSTANT_S, Fault


@dataclass(frozen=True, eq=False)
class _Hit:
    """A stream, and the sensors in it that a fault hits."""

    stream: GivenRows
    fault: Fault
    model: StateSpaceModel
    sensors: tuple[str, ...]
    seed: int

    def within(self, time_s: Array) -> NDArray[np.int64]:
        """Return the rows of stamps (n,) within the fault's time, its end not included.

        Of a fault at single instants all from its begin on.
        """
        later, fault = time_s >= self.fault.at_s - INSTANT_S, self.fault
        before = time_s < fault.end_s - INSTANT_S
        return np.flatnonzero(later if fault.is_at_instants else later & before)

    def rng(self, purpose: str) -> np.random.Generator:
        return stream(seed_sequence(self.seed), f"{self.fault.key} of {purpose}")


def injected(fault: Fault, clean: GivenRows, model: StateSpaceModel, seed: int) -> GivenRows:
    """Return the rows of a fault-free recording as a fault leaves them.

    Parameters
    ----------
    seed : of what is random about the fault
    """
    of = targets_of(model, fault.of)
    assert of, f"{fault.key}: {model.name} has no {fault.of}"
    given = _Hit(clean, fault, model, of, seed)
    return INJECTIONS[fault.does](given)


def _of_readings(change: Callable[[HitReadings], Array]) -> Callable[[_Hit], GivenRows]:
    def inject(given: _Hit) -> GivenRows:
        found = given.stream
        for name in given.sensors:
            time_s, values = given.stream.sensor(name)
            hit = given.within(time_s)
            sensor = given.model.sensor(name)
            changed = change(HitReadings(given.fault, sensor, time_s, values, hit, given.rng(name)))
            found = found.changed(name, given.stream.rows_of(name)[hit], changed)
        return found

    return inject


def hole(given: _Hit) -> GivenRows:
    """No instants at all."""
    rows = np.arange(len(given.stream.time_s))
    return given.stream.taken(np.setdiff1d(rows, given.within(given.stream.time_s)))


def switched_on(given: _Hit) -> GivenRows:
    """Nothing before it begins."""
    return given.stream.taken(given.within(given.stream.time_s))


def jitter(given: _Hit) -> GivenRows:
    """Stamps off by up to a size either way, then sorted; readings stay in their order."""
    rows, size = given.within(given.stream.time_s), given.fault.size
    time_s = given.stream.time_s.copy()
    time_s[rows] += given.rng("stamps").uniform(-size, size, len(rows))
    return GivenRows(np.sort(time_s), given.stream.readings)


def late(given: _Hit) -> GivenRows:
    """Stamps of some sensors a size later, those of the others as they were."""
    parts = {name: given.stream.sensor(name) for name in given.stream.readings}
    for name in given.sensors:
        time_s, values = parts[name]
        parts[name] = (time_s + given.fault.size, values)
    return GivenRows.merged(parts)


def clock_off(given: _Hit) -> GivenRows:
    """Stamps of some sensors by a clock that is fast by a share."""
    parts = {name: given.stream.sensor(name) for name in given.stream.readings}
    for name in given.sensors:
        time_s, values = parts[name]
        parts[name] = (time_s * (1 + given.fault.size), values)
    return GivenRows.merged(parts)


def others_readings(given: _Hit) -> GivenRows:
    """Readings of a sensor are those of another inertial one, where both have one."""
    found = given.stream
    for name in given.sensors:
        other = next(each for each in targets_of(given.model, "imu") if each != name)
        rows = np.intersect1d(given.stream.rows_of(name), given.stream.rows_of(other))
        rows = rows[given.within(given.stream.time_s[rows])]
        found = found.changed(name, rows, given.stream.readings[other][rows])
    return found


def thinned(given: _Hit) -> GivenRows:
    """A sensor's first reading of each period of a rate in Hz, and no other."""
    parts = {}
    for name in given.stream.readings:
        time_s, values = given.stream.sensor(name)
        period = np.floor((time_s + INSTANT_S) * given.fault.size)
        kept = np.diff(period, prepend=-1.0) > 0
        parts[name] = (time_s[kept], values[kept])
    return GivenRows.merged(parts)


def twice_at_once(given: _Hit) -> GivenRows:
    """Every row twice under one stamp."""
    counts = np.ones(len(given.stream.time_s), dtype=int)
    counts[given.within(given.stream.time_s)] = 2
    return given.stream.taken(np.repeat(np.arange(len(counts)), counts))


def twice_later(given: _Hit) -> GivenRows:
    """Every reading again half a period of its sensor later."""
    parts = {}
    for name in given.stream.readings:
        time_s, values = given.stream.sensor(name)
        hit, rate_hz = given.within(time_s), given.model.sensor(name).rate_hz
        assert rate_hz is not None
        again = time_s[hit] + 0.5 / rate_hz
        parts[name] = (np.append(time_s, again), np.vstack([values, values[hit]]))
    return GivenRows.merged(parts)


def swapped_rows(given: _Hit) -> GivenRows:
    """Neighbouring rows arrive in each other's place, with their stamps."""
    rows, hit = np.arange(len(given.stream.time_s)), given.within(given.stream.time_s)
    rows[hit] = swapped(hit)
    return given.stream.taken(rows)


INJECTIONS: Mapping[str, Callable[[_Hit], GivenRows]] = MappingProxyType(
    {
        **{name: _of_readings(change) for name, change in {**READINGS, **BEYOND_READINGS}.items()},
        **{
            each.__name__: each
            for each in (
                *(hole, switched_on, jitter, late, clock_off, thinned),
                *(others_readings, twice_at_once, twice_later, swapped_rows),
            )
        },
    }
)
"""What a fault does → how."""
