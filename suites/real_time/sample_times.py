"""Time per sample on the D-POINT recording, its camera included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmark.tasks.task import Outcome, Quantity
from models.arrays import Array
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from suites.real_time.streams import Stream

NameT = TypeVar("NameT")
CHUNK = 50
CAMERA = "camera"
CONTENDERS: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "ekf": ("ekf", {}),
        "mhe-rti N=20": ("mhe-rti", {"horizon": 20}),
        "mhe-rti N=20 full passes": ("mhe-rti", {"horizon": 20, "reuse_threshold": 0.0}),
        "mhe-rti N=100": ("mhe-rti", {"horizon": 100}),
        "mhe-rti N=100 full passes": ("mhe-rti", {"horizon": 100, "reuse_threshold": 0.0}),
        "mhe N=20": ("mhe", {"horizon": 20}),
    }
)
"""Name → estimator and its settings."""


@dataclass(frozen=True, eq=False)
class Run:
    """An estimator, and the rows (n,), (n, n_row) that it is given."""

    estimator: Any
    time_s: Array
    y: Array


MEDIAN, MEAN, P99, LONGEST, FRAME = (
    *("median time", "mean time", "99 % time", "longest time", "median time with a frame"),
)


def time_quantities(
    times_s: Array, has_frame: NDArray[np.bool_], after: str = ""
) -> tuple[Quantity, ...]:
    """Return what is said of times (n,): of all, and of those with a frame.

    Parameters
    ----------
    after : what stands behind each quantity's name
    """
    figures = {
        MEDIAN: np.median(times_s),
        MEAN: times_s.mean(),
        P99: np.quantile(times_s, 0.99),
        LONGEST: times_s.max(),
        FRAME: np.median(times_s[has_frame]),
    }
    return tuple(Quantity.single(name + after, "µs", 1e6 * float(s)) for name, s in figures.items())


def time_race(stream: Stream) -> dict[str, Outcome]:
    """Run all contenders over the recording, in turns."""
    model = stream.model
    time_s, y = stream.recording.stacked(model)
    runs = {
        name: Run(create_estimator(estimator, model, **settings), time_s, y)
        for name, (estimator, settings) in CONTENDERS.items()
    }
    is_frame = np.asarray(np.isfinite(y[:, camera_columns(model)]).any(axis=1))
    return {
        name: Outcome(
            model.name,
            time_quantities(times, is_frame),
            len(times),
            1.0,
            float(np.median(times)),
            float(np.quantile(times, 0.99)),
        )
        for name, times in in_turns(runs).items()
    }


def in_turns(runs: Mapping[NameT, Run]) -> dict[NameT, Array]:
    """Return the times (n,) of the steps of each run, s; they take turns of some rows each."""
    states = {name: run.estimator.init() for name, run in runs.items()}
    took: dict[NameT, list[Array]] = {name: [] for name in runs}
    for start in range(0, max(len(run.time_s) for run in runs.values()), CHUNK):
        turn = slice(start, start + CHUNK)
        for name, run in runs.items():
            if start < len(run.time_s):
                rows = run.time_s[turn], run.y[turn]
                states[name], history = run.estimator.batch(states[name], *rows)
                took[name].append(history.step_time_s)
    return {name: np.concatenate(parts) for name, parts in took.items()}


def camera_columns(model: StateSpaceModel) -> slice:
    """Return the camera's columns of the stacked readings."""
    start = 0
    for sensor in model.sensors:
        if sensor.name == CAMERA:
            return slice(start, start + sensor.n_y)
        start += sensor.n_y
    return slice(0, 0)
