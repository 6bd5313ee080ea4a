"""A run with everything that may go wrong with a measurement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimation.recording import Measurement

LATE_AT, EMPTY_AT, INFINITE_AT, ABSURD_AT, SATURATED_AT, OUTLIER_AT = 9, 11, 13, 16, 18, 20


def disturbed(
    measurements: Sequence[Measurement], limit: float = np.nan, outlier: float = 1.0
) -> list[Measurement]:
    """Return the run with a late, an empty, an infinite and an absurd measurement put in.

    Parameters
    ----------
    measurements : at least 20
    limit : what the first row then reads once, for a sensor at its range
    outlier : what is added to its reading another time
    """
    run, n_y = list(measurements), len(measurements[0].y)
    run.insert(LATE_AT, Measurement(run[LATE_AT - 3].time_s, run[LATE_AT - 3].y))
    run.insert(EMPTY_AT, Measurement(run[EMPTY_AT - 1].time_s, np.full(n_y, np.nan)))
    first_infinite = np.where(np.arange(n_y) == 0, -np.inf, run[INFINITE_AT - 1].y)
    run.insert(INFINITE_AT, Measurement(run[INFINITE_AT - 1].time_s, first_infinite))
    run.insert(ABSURD_AT, Measurement(run[ABSURD_AT - 1].time_s, np.full(n_y, 1e200)))
    for at, change in ((SATURATED_AT, lambda y: limit), (OUTLIER_AT, lambda y: y + outlier)):
        y = run[at].y.copy()
        y[0] = change(np.nan_to_num(y[0]))
        run[at] = Measurement(run[at].time_s, y)
    return run
