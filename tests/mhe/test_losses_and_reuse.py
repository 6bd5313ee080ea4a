"""Factors stay under Huber's loss while weights do, and the result says the same either way."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from mhe.reuse import reuse_threshold
from models.pen import pen_model
from models.pen_file import load_pen
from tests.closeness import estimate_error, mean_error
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens

RUN = pens.draw_pen_run(40, seed=8)
OUTLIER_AT, HORIZON = 20, 6
CAMERA = 6
"""Number of the camera's first reading."""


def measurements() -> list[Measurement]:
    """A run with one pose that is a metre off."""
    rows = [Measurement(m.time_s, m.y.copy()) for m in RUN.measurements]
    assert RUN.model.reading_names[CAMERA].startswith("camera")
    rows[OUTLIER_AT].y[CAMERA] += 1.0
    return rows


def rti(threshold: float, k: float | None = 5.0) -> MheRti:
    huber = {} if k is None else {"camera": k}
    return MheRti(RUN.model, MheRtiConfig(horizon=HORIZON, reuse_threshold=threshold, huber=huber))


@pytest.mark.parametrize("threshold", [0.5, 2.0, np.inf])
def test_factors_are_those_that_would_be_made(threshold: float) -> None:
    """An engine without memory of the step before says the same, to the last bit."""
    one, memory = rti(threshold), rti(threshold)
    state, reused = one.init(), []
    for measurement in measurements():
        memory.step(memory.init(), Measurement(-1.0, RUN.measurements[3].y))
        _, fresh = memory.step(state, measurement)
        state, kept = one.step(state, measurement)
        reused.append(kept.reused_stages)
        np.testing.assert_array_equal(kept.state.mean, fresh.state.mean)
        np.testing.assert_array_equal(kept.state.covariance, fresh.state.covariance)
        assert kept.window is not None
        assert fresh.window is not None
        np.testing.assert_array_equal(kept.window.states, fresh.window.states)
    assert max(reused) > 0


def test_a_loss_that_nothing_reaches_is_least_squares_with_its_factors() -> None:
    far, plain = (steps(rti(0.5, k), RUN.measurements) for k in (1e6, None))
    for a, b in zip(far, plain, strict=True):
        assert mean_error(RUN.model, a.state.mean, b.state) < 1e-12
        assert a.reused_stages == b.reused_stages


@needs_compiler
@pytest.mark.parametrize("threshold", [0.5, 2.0])
def test_both_engines_say_the_same(threshold: float) -> None:
    machine, plain = compiled_and_interpreted(lambda: rti(threshold, 2.0))
    for a, b in zip(steps(machine, measurements()), steps(plain, measurements()), strict=True):
        assert estimate_error(RUN.model, a, b) < 1e-9
        assert a.status is b.status


def test_kept_factors_are_near_full_passes() -> None:
    kept, full = (steps(rti(threshold), measurements()) for threshold in (0.5, 0.0))
    off = [mean_error(RUN.model, a.state.mean, b.state) for a, b in zip(kept, full, strict=True)]
    assert max(off) < 0.5


def test_the_model_decides_as_without_a_loss_but_not_with_sparse_noise() -> None:
    model = pen_model(load_pen("reference"), ("accel", "gyro", "camera"))
    losses = {"camera": 5.0}
    assert reuse_threshold(model, MheRtiConfig(huber=losses)) > 0
    assert reuse_threshold(model, MheRtiConfig(huber=losses, sparse_noise=1.0)) == 0
