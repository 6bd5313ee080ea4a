"""Out of reach in machine code: from the same step on as interpreted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.estimator import run_measurements
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from tests.engines import compiled_and_interpreted, needs_compiler
from tests.linear_models import random_walk_system


@pytest.mark.cover
@needs_compiler
@pytest.mark.parametrize(
    "build", [Ekf, lambda model: MheRti(model, MheRtiConfig(horizon=2))], ids=["ekf", "mhe-rti"]
)
@pytest.mark.parametrize(("reach", "first"), [(5.0, 3), (10.0, 12)])
def test_a_random_walk_is_out_of_reach_in_both_engines(
    build: Callable[[Any], Any], reach: float, first: int
) -> None:
    """Without readings: σ² = 1 + 9 t."""
    model = random_walk_system(2, q=9.0, r=1.0, p0=1.0).model.replace(
        reach=np.array([np.inf, reach])
    )
    nothing = [Measurement(float(t), np.full(2, np.nan)) for t in range(20)]
    for estimator in compiled_and_interpreted(lambda: build(model)):
        history = run_measurements(estimator, nothing)
        flags = [Status.OUT_OF_REACH in status for status in history.status]
        np.testing.assert_array_equal(flags, np.arange(20) >= first)
