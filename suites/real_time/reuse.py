"""Kept factors over their threshold: how far from full passes, and how fast.

Contenders take turns by chunks of samples, so that a busy machine slows all of them alike.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from estimation.estimate import EstimateHistory
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.real_time.streams import Stream

CHUNK = 50
"""Samples of a turn."""
FIRST_S = 1.0
"""Left out: what happens at the start is another question."""
THRESHOLDS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, math.inf)
HORIZONS = (20, 100)
FULL = "full passes"
FILTERED = "full passes, arrival cost filtered"
OTHERS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        FILTERED: {"arrival_cost": "filtered"},
        "full passes, one interval more": {"horizon": 1},
    }
)
"""Other full passes, for comparison → what they change; the horizon is added."""


@dataclass(frozen=True)
class ReuseRow:
    """A contender beside full passes of the same horizon.

    Parameters
    ----------
    threshold : in standard deviations; None for the contenders that are not one of a threshold
    rms_std, max_std : distance of the newest state from that of full passes, in posterior
        standard deviations, over samples and states
    reused : share of the window's stages whose factors were kept
    time_ratio : median time of a step to that of full passes
    """

    case: str
    horizon: int
    contender: str
    threshold: float | None
    rms_std: float
    max_std: float
    reused: float
    time_ratio: float


def reuse_rows(
    case: str,
    stream: Stream,
    horizons: Sequence[int] = HORIZONS,
    thresholds: Sequence[float] = THRESHOLDS,
) -> list[ReuseRow]:
    """Run all contenders over a stream."""
    return [row for N in horizons for row in _of_horizon(case, stream, N, thresholds)]


def _of_horizon(
    case: str, stream: Stream, horizon: int, thresholds: Sequence[float]
) -> list[ReuseRow]:
    full = MheRtiConfig(horizon=horizon, reuse_threshold=0.0)
    configs: dict[str, MheRtiConfig] = {FULL: full}
    for name, changes in OTHERS.items():
        more = {**changes, "horizon": horizon + int(str(changes.get("horizon", 0)))}
        configs[name] = replace(full, **more)  # type: ignore[arg-type]
    named = {f"threshold {threshold:g}": threshold for threshold in thresholds}
    for name, threshold in named.items():
        configs[name] = replace(full, reuse_threshold=threshold)
    histories = interleaved(stream, configs)
    time_s = histories[FULL].time_s
    settled = time_s >= time_s[0] + FIRST_S
    rows = []
    for name, history in histories.items():
        wanted = histories[FULL]
        away = distances(stream.model, history, wanted)[settled]
        stages = configs[name].horizon + 1
        rows.append(
            ReuseRow(
                case,
                horizon,
                name,
                0.0 if name == FULL else named.get(name),
                float(np.sqrt(np.mean(away**2))),
                float(np.abs(away).max()),
                float(np.mean(history.reused_stages[settled])) / stages,
                float(
                    np.median(history.step_time_s[settled]) / np.median(wanted.step_time_s[settled])
                ),
            )
        )
    return rows


def interleaved(stream: Stream, configs: Mapping[str, MheRtiConfig]) -> dict[str, EstimateHistory]:
    """Run one ``mhe-rti`` per configuration over the stream, in turns."""
    estimators = {name: MheRti(stream.model, config) for name, config in configs.items()}
    states = {name: estimator.init() for name, estimator in estimators.items()}
    parts: dict[str, list[EstimateHistory]] = {name: [] for name in configs}
    time_s, y = stream.recording.stacked(stream.model)
    for start in range(0, len(time_s), CHUNK):
        turn = slice(start, start + CHUNK)
        for name, estimator in estimators.items():
            states[name], history = estimator.batch(states[name], time_s[turn], y[turn])
            parts[name].append(history)
    return {name: EstimateHistory.joined(found) for name, found in parts.items()}


def distances(model: StateSpaceModel, history: EstimateHistory, wanted: EstimateHistory) -> Array:
    """Return how far the newest states (n, n_x) are apart, in posterior standard deviations."""
    away = model.difference.map(len(history))(history.mean.T, wanted.mean.T).full().T
    scaled: Array = away / wanted.std
    return scaled
