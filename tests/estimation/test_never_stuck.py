"""Holes, slow sampling, models beyond all bounds: finite and positive definite, for good."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest

import pen_mhe as pm
from ekf_baseline.ekf import Ekf
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.state_space import StateSpaceModel
from tests.codegen.exports import exported
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.linear_models import constant_acceleration_system

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=5)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=5)),
}
SENSORS = {"accel+gyro": ("accel", "gyro"), "accel+gyro+camera": ("accel", "gyro", "camera")}


def is_definite(estimate: Estimate) -> bool:
    """Whether the covariance is one, measured in its own deviations, but for rounding."""
    P, std = estimate.state.covariance, estimate.state.std
    if not (np.isfinite(P).all() and (std > 0).all()):
        return False
    return float(np.linalg.eigvalsh(P / np.outer(std, std)).min()) > -1e-13


@cache
def recorded(sensors: tuple[str, ...]) -> tuple[StateSpaceModel, list[Measurement]]:
    recording = pm.simulate("reference", sensors, motion="handwriting", duration_s=14.0)
    model = pm.pen_model("reference", sensors)
    return model, list(recording.measurements(model))


def samples(
    sensors: tuple[str, ...], kept: Callable[[float], bool]
) -> tuple[StateSpaceModel, list[Measurement]]:
    model, measurements = recorded(sensors)
    return model, [m for m in measurements if kept(m.time_s)]


GAPS: dict[str, Callable[[float], bool]] = {
    "1 Hz": lambda t: abs(t - round(t)) < 0.004,
    "holes of 2 and 10 s": lambda t: t < 0.3 or 2.3 < t < 2.6 or t > 12.6,
}


@pytest.mark.cover
@needs_compiler
@pytest.mark.parametrize("gaps", GAPS)
@pytest.mark.parametrize("sensors", SENSORS)
@pytest.mark.parametrize("name", ESTIMATORS)
def test_gaps(name: str, sensors: str, gaps: str) -> None:
    model, measurements = samples(SENSORS[sensors], GAPS[gaps])
    assert len(measurements) > 10
    for estimate in steps(ESTIMATORS[name](model), measurements):
        assert np.isfinite(estimate.state.mean).all()
        assert is_definite(estimate)


@needs_compiler
@pytest.mark.parametrize(
    ("name", "real", "form"),
    [
        pytest.param("ekf", "double", "covariance", marks=pytest.mark.slow),
        ("ekf", "float", "root"),
        ("mhe-rti", "double", "covariance"),
    ],
)
def test_gaps_in_an_export(name: str, real: str, form: str) -> None:
    model, measurements = samples(SENSORS["accel+gyro"], GAPS["1 Hz"])
    for estimate in steps(exported(name, model, real, form), measurements):
        assert np.isfinite(estimate.state.mean).all()
        assert (estimate.state.std > 0).all()


def explosive() -> StateSpaceModel:
    """Goes beyond all numbers within a long enough step, whatever the readings."""
    model = constant_acceleration_system(1).model
    x, w, dt = ca.SX.sym("x", 3), ca.SX.sym("w", 3), ca.SX.sym("dt")
    return model.replace(f=ca.Function("f", [x, w, dt], [x * ca.exp(1000 * dt * dt) + w * dt]))


@needs_compiler
@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_last_rung_is_a_state_that_says_what_it_is(name: str) -> None:
    model = explosive()
    y = np.array([0.1, 0.2])
    times = [0.0, 0.01, 0.02, 2.0, 2.01, 2.02, 2.03]
    for estimator in compiled_and_interpreted(lambda: ESTIMATORS[name](model)):
        estimates = steps(estimator, [Measurement(t, y) for t in times])
        assert [Status.NOT_FINITE in e.status for e in estimates] == [t == 2.0 for t in times]
        assert not estimates[3].status.is_solved
        np.testing.assert_allclose(estimates[3].state.mean, estimates[2].state.mean, rtol=1e-12)
        for estimate in estimates:
            assert np.isfinite(estimate.state.mean).all()
            assert is_definite(estimate)
        assert all(e.status.is_solved for e in estimates[4:])
