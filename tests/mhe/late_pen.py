"""A pen whose readings come late, and an estimator that has seen its first ones on time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.window_memory import View
from tests.configs import config_for
from tests.estimation import pens
from tests.mhe.late_streams import in_order, late_stream
from tests.mhe.runs import ESTIMATORS

RUN = pens.draw_pen_run(40, seed=8)
MODEL = RUN.model
STREAM = late_stream(MODEL, RUN.measurements, np.random.default_rng(3))
either_engine = pytest.mark.usefixtures("engine")


def stages_of(window: View, arrived: list[Measurement]) -> tuple[Measurement, ...]:
    """The window's readings in order of capture."""
    return tuple(in_order(arrived, MODEL.n_y)[-len(window.times) :])


def ready(estimator: str, n: int = 10, **settings: Any) -> tuple[Any, Any, Any]:
    """An estimator after n samples that were all on time, its state and last estimate."""
    mhe = ESTIMATORS[estimator](MODEL, config_for(estimator, **{"horizon": 6, **settings}))
    state, estimate = mhe.init(), None
    for measurement in RUN.measurements[:n]:
        state, estimate = mhe.step(state, measurement)
    return mhe, state, estimate


def between(k: int, share: float = 0.4) -> float:
    """An instant between two samples."""
    before, behind = RUN.measurements[k].time_s, RUN.measurements[k + 1].time_s
    return before + share * (behind - before)
