"""Time per sample on the D-POINT recording, its camera included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

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
        "mhe-rti, N = 20": ("mhe-rti", {"horizon": 20}),
        "mhe-rti, N = 20, full passes": ("mhe-rti", {"horizon": 20, "reuse_threshold": 0.0}),
        "mhe-rti, N = 100": ("mhe-rti", {"horizon": 100}),
        "mhe-rti, N = 100, full passes": ("mhe-rti", {"horizon": 100, "reuse_threshold": 0.0}),
        "mhe, N = 20": ("mhe", {"horizon": 20}),
    }
)
"""Name → estimator and its settings."""


@dataclass(frozen=True, eq=False)
class Run:
    """An estimator, and the rows (n,), (n, n_row) that it is given."""

    estimator: Any
    time_s: Array
    y: Array


@dataclass(frozen=True)
class TimeRow:
    """Times of a contender's steps, s: at all instants, and at those with a frame."""

    contender: str
    samples: int
    median_s: float
    p99_s: float
    max_s: float
    frame_median_s: float


def time_rows(stream: Stream) -> list[TimeRow]:
    """Run all contenders over the recording, in turns."""
    time_s, y = stream.recording.stacked(stream.model)
    runs = {name: Run(_built(stream.model, *made), time_s, y) for name, made in CONTENDERS.items()}
    is_frame = np.isfinite(y[:, camera_columns(stream.model)]).any(axis=1)
    rows = []
    for name, times in in_turns(runs).items():
        rows.append(
            TimeRow(
                name,
                len(times),
                float(np.median(times)),
                float(np.quantile(times, 0.99)),
                float(times.max()),
                float(np.median(times[is_frame])),
            )
        )
    return rows


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


def _built(model: StateSpaceModel, name: str, settings: Mapping[str, Any]) -> Any:
    return create_estimator(name, model, **settings)


def camera_columns(model: StateSpaceModel) -> slice:
    """Return the camera's columns of the stacked readings."""
    start = 0
    for sensor in model.sensors:
        if sensor.name == CAMERA:
            return slice(start, start + sensor.n_y)
        start += sensor.n_y
    return slice(0, 0)
