"""A pen whose camera is late: near the run in order of capture of what had arrived."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmark.bodies import BODIES
from estimation.estimate import Estimate
from estimation.recording import Measurement, Recording
from models.state_space import StateSpaceModel
from suites.real_time.streams import recorded
from tests.closeness import mean_error
from tests.configs import config_for
from tests.mhe.windows import real_time

DELAY_S, LONGEST_S = 0.045, 0.07
NEAR = 0.1
"""Standard deviations."""


def arriving(model: StateSpaceModel, recording: Recording) -> list[Measurement]:
    """The rows of a recording in order of arrival, its camera's late."""
    columns, arrivals = camera_columns(model), list[tuple[float, int, Measurement]]()
    for time_s, y in zip(*recording.stacked(model), strict=True):
        for is_late in (False, True):
            row = np.where(columns == is_late, y, np.nan)
            if np.isfinite(row).any():
                arrives_s = time_s + DELAY_S * is_late
                arrivals.append((arrives_s, len(arrivals), Measurement(float(time_s), row)))
    return [measurement for *_, measurement in sorted(arrivals, key=lambda a: a[:2])]


def camera_columns(model: StateSpaceModel) -> np.ndarray:
    """Which readings (n_y,) are the camera's."""
    names = [sensor.name for sensor in model.sensors for _ in range(sensor.n_y)]
    return np.array(names) == "camera"


def beside(
    estimator: str, model: StateSpaceModel, stream: list[Measurement], **settings: Any
) -> Iterator[tuple[Estimate, Estimate]]:
    """Estimates of a stream, and those of a run in order of capture of what had arrived by then.

    The second goes on with what is older than any that may come, and from there through the rest.
    Where a frame is late it makes one more pass, as the first has made one with the newest sample
    before and one now: on a stroke of the real pen a sample's first pass leaves 0.11 deviations.
    """
    mhe, other = (
        real_time(estimator, model, config_for(estimator, horizon=26, **settings)) for _ in range(2)
    )
    state, settled = mhe.init(), other.init()
    waiting, newest_s = list[Measurement](), -np.inf
    for measurement in stream:
        state, estimate = mhe.step(state, measurement)
        is_late = measurement.time_s < newest_s
        newest_s = max(newest_s, measurement.time_s)
        waiting = sorted([*waiting, measurement], key=lambda m: m.time_s)
        while waiting[0].time_s < newest_s - LONGEST_S:
            settled, _ = other.step(settled, waiting.pop(0))
        at, wanted = settled, estimate
        for m in waiting:
            at, wanted = other.step(at, m)
        if is_late:
            before = max(m.time_s for m in waiting if m.time_s < newest_s)
            _, wanted = other.step(at, Measurement(before, np.full(model.n_row, np.nan)))
        yield estimate, wanted


def farthest(
    estimator: str, model: StateSpaceModel, stream: list[Measurement], **settings: Any
) -> float:
    """How far both are from each other at most, the first estimate with a frame included."""
    return max(
        mean_error(model, one.state.mean, other.state)
        for one, other in beside(estimator, model, stream, **settings)
    )


@pytest.mark.parametrize("threshold", [0.5, 0.0])
def test_a_simulated_pen(threshold: float) -> None:
    moving = BODIES["pen24"]()
    model = moving.model()
    stream = arriving(model, moving.record(1.2, 0))
    off = farthest("mhe-rti", model, stream, reuse_threshold=threshold)
    assert 1e-6 < off < NEAR


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimator", "settings"),
    [("mhe-rti", {}), ("mhe-rti", {"reuse_threshold": 0.0}), ("mhe", {})],
)
def test_a_real_pen(data_folder: Path, estimator: str, settings: dict[str, Any]) -> None:
    written = recorded(1, data_folder)
    stream = arriving(written.model, written.recording)[: 5796 if estimator == "mhe-rti" else 900]
    assert farthest(estimator, written.model, stream, **settings) < NEAR
