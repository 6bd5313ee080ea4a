"""Time per sample on the D-POINT recording, its camera included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ekf_baseline.ekf import Ekf
from mhe.config import MheConfig
from mhe.realtime import Mhe, MheRti
from models.state_space import StateSpaceModel
from suites.real_time.streams import Stream

CHUNK = 50
CAMERA = "camera"
CONTENDERS: Mapping[str, tuple[Any, MheConfig | None]] = MappingProxyType(
    {
        "ekf": (Ekf, None),
        "mhe-rti, N = 20": (MheRti, MheConfig(20)),
        "mhe-rti, N = 20, full passes": (MheRti, MheConfig(20, reuse_threshold=0.0)),
        "mhe-rti, N = 100": (MheRti, MheConfig(100)),
        "mhe-rti, N = 100, full passes": (MheRti, MheConfig(100, reuse_threshold=0.0)),
        "mhe, N = 20": (Mhe, MheConfig(20)),
    }
)
"""Name → estimator and its settings."""


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
    estimators = {name: _built(stream.model, *made) for name, made in CONTENDERS.items()}
    states = {name: estimator.init() for name, estimator in estimators.items()}
    took: dict[str, list[np.ndarray]] = {name: [] for name in CONTENDERS}
    for start in range(0, len(time_s), CHUNK):
        turn = slice(start, start + CHUNK)
        for name, estimator in estimators.items():
            states[name], history = estimator.batch(states[name], time_s[turn], y[turn])
            took[name].append(history.step_time_s)
    is_frame = np.isfinite(y[:, _columns(stream.model)]).any(axis=1)
    rows = []
    for name, parts in took.items():
        times = np.concatenate(parts)
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


def _built(model: StateSpaceModel, kind: Any, config: MheConfig | None) -> Any:
    return kind(model) if config is None else kind(model, config)


def _columns(model: StateSpaceModel) -> slice:
    """Return the camera's columns of the stacked readings."""
    start = 0
    for sensor in model.sensors:
        if sensor.name == CAMERA:
            return slice(start, start + sensor.n_y)
        start += sensor.n_y
    return slice(0, 0)
