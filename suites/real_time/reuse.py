"""Kept factors over their threshold: how far from full passes, and how fast.

Contenders take turns by chunks of samples, so that a busy machine slows all of them alike.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from benchmark.tasks.history import outcome
from benchmark.tasks.task import Outcome, Quantity
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
FILTERED = "full passes with filtered arrival cost"
OTHERS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        FILTERED: {"arrival_cost": "filtered"},
        "full passes with one interval more": {"longer": 1},
    }
)
"""Other full passes, for comparison → what they change; ``longer`` is added to the horizon."""


NEWEST, KEPT, TIME = "newest state", "stages kept", "time per step"
"""Distance from full passes, in posterior standard deviations over samples and states; share of the
window's stages whose factors were kept; median time of a step to that of full passes."""


def threshold_name(threshold: float) -> str:
    """Return the name of the contender that keeps factors below a threshold."""
    return f"threshold {threshold:g}"


CONTENDERS: Mapping[str, float] = MappingProxyType(
    {
        **dict.fromkeys((FULL, *OTHERS), 0.0),
        **{threshold_name(threshold): threshold for threshold in THRESHOLDS},
    }
)
"""Name → its threshold, in standard deviations."""


def reuse_race(stream: Stream, horizon: int) -> dict[str, Outcome]:
    """Run all contenders over a stream; return what each found beside full passes."""
    configs = {name: _config(name, horizon) for name in CONTENDERS}
    histories = interleaved(stream, configs)
    full, found = histories[FULL], {}
    settled = full.time_s >= full.time_s[0] + FIRST_S
    full_s = np.median(full.step_time_s[settled])
    for name, history in histories.items():
        away = distances(stream.model, history, full)[settled]
        stages = configs[name].horizon + 1
        kept = float(np.mean(history.reused_stages[settled])) / stages
        time = float(np.median(history.step_time_s[settled]) / full_s)
        quantities = (
            Quantity.of_errors(NEWEST, "σ", away.ravel()),
            Quantity.single(KEPT, "1", kept),
            Quantity.single(TIME, "full passes", time),
        )
        found[name] = outcome(stream.model.name, history, quantities)
    return found


def _config(name: str, horizon: int) -> MheRtiConfig:
    full = MheRtiConfig(horizon=horizon, reuse_threshold=CONTENDERS[name])
    changes = dict(OTHERS.get(name, {}))
    longer = horizon + int(str(changes.pop("longer", 0)))
    return replace(full, horizon=longer, **changes)  # type: ignore[arg-type]


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
