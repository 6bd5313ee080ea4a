"""A day of a filter, two hours of a moving horizon: memory stays, claims hold at the end.

``python -m tests.estimation.test_long_streams ekf 24 accel gyro camera`` prints the figures of one
stream: estimator, hours, sensors. The motion is random and bounded, the biases stay.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from estimation.driven import Driven
from estimation.orders import InOrderOfCapture
from estimation.true_error import true_errors
from models.pen_file import load_pen
from pen_mhe.estimators import create_estimator
from tests.endless_pen import PART_S, EndlessPen

STATM = Path("/proc/self/statm")
WARM_UP_PARTS = 10
"""Until the allocator has all it wants."""
MOST_GROWTH_BYTES = 5e6
STREAMS = (
    ("ekf", 24.0, ("accel", "gyro")),
    ("ekf", 24.0, ("accel", "gyro", "camera")),
    ("mhe-rti", 2.0, ("accel", "gyro")),
    ("mhe-rti", 2.0, ("accel", "gyro", "camera")),
)


@dataclass(frozen=True)
class End:
    """What is left of a stream.

    Parameters
    ----------
    steps : that were made
    grown_bytes : resident memory, from the warm-up on
    least_eigenvalue : of any part's last covariance, in units of its standard deviations
    largest_error : of the last estimate's states, in claimed deviations
    solved : fraction of the steps
    """

    steps: int
    grown_bytes: int
    least_eigenvalue: float
    largest_error: float
    solved: float


def resident_bytes() -> int:
    gc.collect()
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def follow(estimator: str, hours: float, sensors: Sequence[str]) -> End:
    """Drive an estimator through so many hours, and keep nothing but the end."""
    pen = EndlessPen(load_pen("reference"), sensors)
    model, order = pen.model, InOrderOfCapture(pen.model)
    driven = Driven(create_estimator(estimator, model), covariances=True)
    steps, solved, least, warm, error = 0, 0.0, np.inf, 0, np.inf
    for number, part in enumerate(islice(pen.parts(), round(3600 * hours / PART_S))):
        history = driven.take(order.take(part))
        P, std = history.covariance[-1], history.std[-1]
        least = min(least, float(np.linalg.eigvalsh(P / np.outer(std, std)).min()))
        steps, solved = steps + len(history), solved + history.solved_fraction * len(history)
        assert part.truth is not None
        states = part.truth.states(model.state_names, history.time_s[-1:])
        error = float((np.abs(true_errors(model, history.mean[-1:], states)) / std).max())
        assert np.isfinite(history.mean).all()
        del history
        if number == WARM_UP_PARTS:
            warm = resident_bytes()
    return End(steps, resident_bytes() - warm, least, error, solved / steps)


@pytest.mark.slow
@pytest.mark.skipif(not STATM.exists(), reason="no /proc/self/statm")
@pytest.mark.parametrize(("estimator", "hours", "sensors"), STREAMS)
def test_claims_hold_at_the_end(estimator: str, hours: float, sensors: Sequence[str]) -> None:
    end = follow(estimator, hours, sensors)
    assert end.steps >= 360_000 * hours
    assert end.grown_bytes < MOST_GROWTH_BYTES
    assert end.least_eigenvalue > 0
    assert end.largest_error <= 3
    assert end.solved == 1


if __name__ == "__main__":
    print(follow(sys.argv[1], float(sys.argv[2]), sys.argv[3:]))
