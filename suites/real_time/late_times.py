"""Time per sample of the D-POINT recording's IMU, its frames at their capture and as they arrive.

A sample's time is that of all rows since the sample before: a frame that comes between two counts
with the second.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmark.tasks.task import Outcome, Quantity
from models.arrays import Array
from pen_mhe.estimators import create_estimator
from suites.real_time.sample_times import Run, camera_columns, in_turns, time_quantities
from suites.real_time.streams import Stream

ROUNDS = 3
"""Over the whole recording. Of a row's times the least counts: in the others the processor was
elsewhere."""
HORIZON = 26
CONTENDERS: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "ekf": ("ekf", {}),
        f"mhe-rti N={HORIZON}": ("mhe-rti", {"horizon": HORIZON}),
        f"mhe-rti N={HORIZON} full passes": (
            "mhe-rti",
            {"horizon": HORIZON, "reuse_threshold": 0.0},
        ),
    }
)
"""Name → estimator and its settings."""
ORDERS = ("at capture", "as they arrive")
"""Of the rows."""


def ordered(order: str) -> str:
    """Return what stands behind the names of quantities of an order."""
    return f", frames {order}"


def late_race(stream: Stream) -> dict[str, Outcome]:
    """Run all contenders over the recording in both orders, in turns."""
    model, recording = stream.model, stream.recording
    of = dict(zip(ORDERS, (recording.stacked(model), recording.as_arrived(model)[:2]), strict=True))
    runs = {
        (name, order): Run(create_estimator(estimator, model, **settings), *of[order])
        for name, (estimator, settings) in CONTENDERS.items()
        for order in ORDERS
    }
    rounds = [in_turns(runs) for _ in range(ROUNDS)]
    seen, found = camera_columns(model), {}
    for name in CONTENDERS:
        quantities = list[Quantity]()
        for order in ORDERS:
            has_reading = np.isfinite(of[order][1])
            is_frame = has_reading[:, seen].any(axis=1)
            is_sample = np.asarray(np.delete(has_reading, seen, axis=1).any(axis=1))
            took = np.min([each[name, order] for each in rounds], axis=0)
            times = per_sample(took, is_sample)
            frames = per_sample(is_frame.astype(float), is_sample) > 0
            quantities += time_quantities(times, frames, ordered(order))
        # What the last order left: frames as they arrive are what a live pen has.
        median, p99 = float(np.median(times)), float(np.quantile(times, 0.99))
        found[name] = Outcome(model.name, tuple(quantities), len(times), 1.0, median, p99)
    return found


def per_sample(values: Array, is_sample: NDArray[np.bool_]) -> Array:
    """Return sums (n_samples,) over the rows (n,) up to each sample, since the one before."""
    upto = np.cumsum(values)[is_sample]
    return np.diff(upto, prepend=0.0)
