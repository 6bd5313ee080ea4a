"""Late readings in an export: what is said here, to the last bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.pen import pen_model
from models.pen_file import load_pen
from recordings.simulate_pen import simulate
from tests.closeness import estimate_error
from tests.codegen.exports import exported, told
from tests.engines import needs_compiler
from tests.estimation import pens
from tests.linear_models import coupled_system
from tests.mhe.late_streams import Delays, is_late, late_stream

pytestmark = needs_compiler

RUN = pens.draw_pen_run(40, seed=11)
STREAM = late_stream(RUN.model, RUN.measurements, np.random.default_rng(2))
KEPT = {"horizon": 9, "reuse_threshold": 0.5}


def test_it_is_what_runs_here_to_the_last_bit() -> None:
    ours = told(exported("mhe-rti", RUN.model, settings=KEPT), STREAM)
    here = told(MheRti(RUN.model, MheRtiConfig(**KEPT)), STREAM)
    late = 0
    for k, (a, b) in enumerate(zip(ours, here, strict=True)):
        assert a.time_s == b.time_s
        assert a.status is b.status
        for name in ("mean", "covariance"):
            np.testing.assert_array_equal(getattr(a.state, name), getattr(b.state, name))
        np.testing.assert_array_equal(a.innovation, b.innovation)
        np.testing.assert_array_equal(a.innovation_covariance, b.innovation_covariance)
        assert (a.kkt_residual, a.reused_stages) == (b.kkt_residual, b.reused_stages)
        late += is_late(STREAM, k) and Status.LATE not in a.status
    assert late > 6


def test_single_precision_is_near() -> None:
    """Also where the times of its loop have begun anew many times."""
    system, rng = coupled_system(3), np.random.default_rng(1)
    measurements = system.simulate(np.cumsum(rng.uniform(0.005, 0.02, 300)), rng, missing=0.2)
    stream = late_stream(system.model, measurements, rng, Delays(most=4))
    settings = {"horizon": 12}
    single, double = (
        told(exported("mhe-rti", system.model, real, settings=settings), stream)
        for real in ("float", "double")
    )
    for a, b in zip(single, double, strict=True):
        assert estimate_error(system.model, a, b) < 1e-4
        assert a.time_s == b.time_s
        assert a.status is b.status


def test_older_than_its_window_changes_nothing() -> None:
    estimator = exported("mhe-rti", RUN.model)
    state = estimator.init()
    for measurement in RUN.measurements[:10]:
        state, before = estimator.step(state, measurement)
    after, late = estimator.step(state, replace(RUN.measurements[2], y=RUN.measurements[9].y))
    assert late.status is Status.LATE
    assert late.time_s == before.time_s
    _, one = estimator.step(state, RUN.measurements[10])
    _, other = estimator.step(after, RUN.measurements[10])
    np.testing.assert_array_equal(one.state.mean, other.state.mean)


@pytest.mark.parametrize("real", ["double", "float"])
def test_a_late_reading_brings_no_writing_area(real: str) -> None:
    """It is a reading of the instants that arrive in their order."""
    pen = load_pen("reference")
    model = pen_model(pen, ("accel", "gyro", "camera"), writing_area=True)
    recording = simulate(pen, ("accel", "gyro", "camera"), duration_s=0.3, seed=2)
    measurements = list(replace(recording, truth=None).measurements(model))
    estimator = exported("mhe-rti", model, real, settings={"horizon": 9})
    state = estimator.init()
    for measurement in measurements[:20]:
        state, _ = estimator.step(state, measurement)
    late = Measurement(measurements[15].time_s + 1e-3, measurements[15].y)
    _, estimate = estimator.step(state, late)
    start = 0
    for sensor in model.sensors:
        rows = estimate.innovation[start : start + sensor.n_r]
        if sensor.constant_reading is not None:
            assert np.isnan(rows).all()
        start += sensor.n_r
    assert np.isfinite(estimate.innovation).any()
