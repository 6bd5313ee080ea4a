"""What is measured of a run from a bad start."""

from __future__ import annotations

import numpy as np

from benchmark.tasks.task import Quantity, Series
from models.arrays import Array
from suites.bad_starts.run import FIRST_S, BadStartRun

AT_S = (0.1, 1.0, 5.0)
"""Instants of which the error is said, where a run is that long."""
WITHIN_DEG, WITHIN_STD = 3.0, 3.0
"""A run counts as arrived where its error is this small, and as honest where it is within that
many of its claimed deviations."""

UP, RATES = "up", "body rates"
FIRST_UP, FIRST_RATES = (f"{name}, first second" for name in (UP, RATES))
NEAR = f"within {WITHIN_DEG:g} deg after {FIRST_S:g} s"
HONEST = f"within {WITHIN_STD:g} deviations after {FIRST_S:g} s"
END = "end error over its deviation"
"""1.18 in the median where it is honest and Gaussian in two directions, 0.67 in one."""

DENSE, SPARSE = 2, 10
"""Every so many samples of the first second, and of what follows, figures show."""


def up_after(after_s: float) -> str:
    """Return the name of the error of up so long after the start."""
    return f"{UP} after {after_s:g} s"


def quantities(run: BadStartRun) -> list[Quantity]:
    """Return the errors of a run; of an instant that it does not reach none."""
    up, std = np.degrees(run.error), np.degrees(run.std)
    first = run.is_first
    found = [
        Quantity.of_errors(FIRST_UP, "deg", up[first], claimed=std[first]),
        Quantity.of_errors(FIRST_RATES, "rad/s", run.rate_error[first]),
    ]
    for after_s in AT_S:
        error, claimed = (np.array([run.at(values, after_s)]) for values in (up, std))
        if np.isfinite(error).all():
            found.append(Quantity.of_errors(up_after(after_s), "deg", error, claimed=claimed))
    error_rad, std_rad = run.at(run.error, FIRST_S), run.at(run.std, FIRST_S)
    return [
        *found,
        Quantity.single(NEAR, "1", float(error_rad <= np.radians(WITHIN_DEG))),
        Quantity.single(HONEST, "1", float(error_rad / std_rad <= WITHIN_STD)),
        Quantity.single(END, "1", float(run.error[-1] / run.std[-1])),
    ]


def series(run: BadStartRun) -> tuple[Series, ...]:
    """Return the errors over time, thinned by `DENSE` and `SPARSE`."""
    k = np.arange(len(run.time_s))
    kept = np.where(run.is_first, k % DENSE == 0, k % SPARSE == 0)

    def thinned(quantity: str, unit: str, values: Array) -> Series:
        return Series(quantity, unit, run.time_s[kept], values[kept])

    return (
        thinned(UP, "deg", np.degrees(run.error)),
        thinned(RATES, "rad/s", run.rate_error),
    )
