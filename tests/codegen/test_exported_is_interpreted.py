"""An export in double precision is the estimator as CasADi's virtual machine computes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.gaussian import GaussianState
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from recordings.simulate_pen import simulate
from tests.closeness import estimate_error
from tests.codegen.exports import Settings, exported, interpreted, told
from tests.disturbed import ABSURD_AT, EMPTY_AT, INFINITE_AT, LATE_AT, SATURATED_AT, disturbed
from tests.engines import needs_compiler
from tests.estimation import pens
from tests.mhe import pendulum

pytestmark = needs_compiler

PER_STEP, AFTER_LONG = 1e-12, 1e-9
RUN = pens.draw_pen_run(60, seed=11)
ACCEL, *OTHERS = RUN.model.sensors
PEN = RUN.model.replace(sensors=(replace(ACCEL, reading_limit=40.0), *OTHERS))
PENDULUM = pendulum.model()
SWING = pendulum.simulate(40, seed=3)


def compare(
    name: str,
    model: StateSpaceModel,
    measurements: list[Measurement],
    settings: Settings | None = None,
) -> list[Estimate]:
    """Compare every step; return the export's estimates."""
    ours = told(exported(name, model, settings=settings), measurements)
    plain = told(interpreted(name, model, settings), measurements)
    for a, b in zip(ours, plain, strict=True):
        assert estimate_error(model, a, b) < PER_STEP
        assert a.status is b.status
        assert a.time_s == b.time_s
        assert a.iterations == b.iterations
    return ours


@pytest.mark.usefixtures("optimised")
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_whatever_goes_wrong_with_a_measurement(name: str) -> None:
    estimates = compare(name, PEN, disturbed(RUN.measurements, limit=39.99, outlier=3.0))
    status = [estimate.status for estimate in estimates]
    assert estimates[LATE_AT].time_s == estimates[LATE_AT - 1].time_s
    assert status[EMPTY_AT] is Status.NO_READING
    assert Status.INFINITE_READING in status[INFINITE_AT]
    assert status[ABSURD_AT] & (Status.SATURATED | Status.NOT_FINITE)
    assert Status.SATURATED in status[SATURATED_AT]


@pytest.mark.usefixtures("optimised")
def test_it_is_what_runs_here_to_the_last_bit() -> None:
    """The same C, with what only it tells: factors kept, distance from the optimum."""
    settings = {"horizon": 6, "reuse_threshold": 0.5}
    ours = told(exported("mhe-rti", PENDULUM, settings=settings), SWING)
    here = told(MheRti(PENDULUM, MheRtiConfig(**settings)), SWING)
    for a, b in zip(ours, here, strict=True):
        np.testing.assert_array_equal(a.state.mean, b.state.mean)
        np.testing.assert_array_equal(a.state.covariance, b.state.covariance)
        assert (a.kkt_residual, a.reused_stages) == (b.kkt_residual, b.reused_stages)
    assert max(estimate.reused_stages for estimate in ours) > 2


def test_a_gate() -> None:
    measurements = list(SWING)
    measurements[20] = Measurement(SWING[20].time_s, SWING[20].y + 5)
    estimates = compare("ekf", PENDULUM, measurements, {"gate_probability": 0.99})
    assert Status.GATED in estimates[20].status


def test_losses() -> None:
    settings = {"horizon": 4, "huber": {"level": 2.0}, "sparse_noise": 1.0}
    compare("mhe-rti", PENDULUM, SWING, settings)


@pytest.mark.parametrize("arrival_cost", ["none", "constant", "filtered", "smoothed"])
def test_every_arrival_cost(arrival_cost: str) -> None:
    compare("mhe-rti", PENDULUM, SWING, {"horizon": 3, "arrival_cost": arrival_cost})


def test_bounds_hold() -> None:
    model = PENDULUM.bounded(s0_m=(-0.3, 0.3))
    angles = np.array([e.state.mean[0] for e in compare("mhe-rti", model, SWING)])
    assert np.abs(angles).max() < 0.3 + 1e-3
    assert (np.abs(angles) > 0.3 - 1e-6).any(), "a bound is active somewhere"


def test_the_step_adds_the_writing_area() -> None:
    """Its readings are in the measurements that Python takes, and not in those that C is given."""
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": 5})
    model = pen_model(pen, ["accel"])
    assert [sensor.name for sensor in model.sensors if sensor.constant_reading is not None]
    recording = simulate(pen, ["accel"], motion="turn", duration_s=0.3, seed=2)
    shifted = replace(recording, time_s=recording.time_s + 12.34567, truth=None)
    measurements = list(shifted.measurements(model))
    area = np.isfinite([m.y[-1] for m in measurements])
    assert area.any()
    compare("ekf", model, measurements)


def test_a_turntable() -> None:
    model = turntable_model(paper_turntable(), ("accel", "gyro"))
    rng = np.random.default_rng(4)
    h = np.concatenate([np.asarray(s.h(model.prior.mean)).ravel() for s in model.sensors])
    readings = h + model.noise_std * rng.standard_normal((25, model.n_y))
    measurements = [Measurement(0.01 * k, y) for k, y in enumerate(readings)]
    for name in ("ekf", "mhe-rti"):
        compare(name, model, measurements)


def test_an_angle_beyond_half_a_turn() -> None:
    mean = PEN.prior.mean.copy()
    mean[3], mean[8] = np.pi - 0.01, 5.0
    model = PEN.replace(prior=GaussianState(mean, PEN.prior.covariance))
    estimates = compare(
        "ekf", model, [Measurement(0.01 * k, np.full(12, np.nan)) for k in range(9)]
    )
    assert estimates[-1].state.mean[3] < -2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_after_ten_thousand_steps(name: str) -> None:
    """A run again and again, each time behind the one before."""
    once = disturbed(RUN.measurements, limit=39.99)
    lasts = max(m.time_s for m in once) + 0.01
    n = 10_000 // len(once) + 1
    many = [Measurement(m.time_s + k * lasts, m.y) for k in range(n) for m in once]
    assert len(many) >= 10_000
    ours, plain = exported(name, PEN), interpreted(name, PEN)
    state, other = ours.init(), plain.init()
    worst = 0.0
    for measurement in many:
        state, a = ours.step(state, measurement)
        other, b = plain.step(other, measurement)
        worst = max(worst, estimate_error(PEN, replace(a, window=None), replace(b, window=None)))
        assert a.status is b.status
    assert worst < AFTER_LONG
