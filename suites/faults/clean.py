"""Fault-free streams: how often a watch blames a sensor that is well, and how long it is lost."""

from __future__ import annotations

import numpy as np

from benchmark.tasks.task import Quantity
from estimation.status import Status
from suites.faults.cells import Bench
from suites.faults.given_rows import GivenRows
from suites.faults.protocol import recorded
from suites.faults.quantities import FLAGS, LOST
from suites.faults.said import Said
from suites.faults.scoring import raised

SPEEDS = (0.3, 1.0, 2.0, 3.0)
"""Factors of the speed that the pen file states."""
CLEAN = {f"clean, speed {speed:g}": speed for speed in SPEEDS}
"""Case → speed."""
LONG_S, SHORT_S = 900.0, 20.0
"""A quarter of an hour on each of ten seeds and four speeds is ten hours; and where only a part of
the table is shown."""
FIRST_SEED = 1000
"""Seeds of no calibration."""
SETTLED_S = 1.0


def flags_raised(told: Said) -> int:
    """Return how often a flag of a sensor goes up, or one that no sensor is blamed for."""
    inconsistent = (told.status & Status.INCONSISTENT.value) != 0
    return sum(raised(of_sensor != 0) for of_sensor in told.flagged.T) + raised(inconsistent)


def run_clean(
    bench: Bench, case: str, seed: int, duration_s: float
) -> tuple[list[Quantity], Said, np.ndarray]:
    """Return what a fault-free stream found, what was said, and step times (n,)."""
    recording = recorded(bench.sensors, FIRST_SEED + seed, duration_s, speed=CLEAN[case])
    history = bench.history(GivenRows.of(recording))
    told = Said.of(history)
    lasting_s = np.diff(history.time_s, append=history.time_s[-1])
    later = history.time_s - history.time_s[0] >= SETTLED_S
    lost = (told.status & Status.LOST.value) != 0
    sensors = len(bench.model.measured_sensors)
    found = [
        Quantity.single(FLAGS, "1", flags_raised(told) / (duration_s / 3600 * sensors)),
        Quantity.single(LOST, "%", 100 * float(lasting_s[lost & later].sum()) / duration_s),
    ]
    return found, told, history.step_time_s
