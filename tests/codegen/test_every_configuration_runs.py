"""Every model of the contract, exported in single precision, says what the estimator says."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Measurement, Recording
from models.state_space import StateSpaceModel
from tests.closeness import covariance_error, mean_error
from tests.codegen.configurations import MODELS, of_a_kind
from tests.codegen.exports import exported, interpreted, told
from tests.engines import needs_compiler

pytestmark = needs_compiler

TOLERANCE_STD = 0.01
"""Two accelerometers alone come to a quarter of it: what they tell of an attitude is a small
difference of large specific forces."""


def at_rest(model: StateSpaceModel, n: int) -> list[Measurement]:
    """100 Hz of noisy readings of the prior's mean."""
    rng, readings = np.random.default_rng(5), {}
    for sensor in model.measured_sensors:
        h = np.asarray(sensor.h(model.prior.mean)).ravel()
        noise = sensor.noise_std.min() * rng.standard_normal((n, sensor.n_y))
        readings[sensor.name] = h + noise
    return list(Recording("at rest", np.arange(n) / 100, readings).measurements(model))


def compare(name: str, model: StateSpaceModel, n: int) -> None:
    measurements = at_rest(model, n)
    ours = told(exported(name, model, "float"), measurements)
    for a, b in zip(ours, told(interpreted(name, model), measurements), strict=True):
        assert mean_error(model, a.state.mean, b.state) < TOLERANCE_STD
        assert covariance_error(a.state.covariance, b.state.covariance) < TOLERANCE_STD
        assert a.status is b.status


@pytest.mark.parametrize("model", of_a_kind())
def test_ekf(model: str) -> None:
    compare("ekf", MODELS[model], 12)


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_mhe_rti(model: str) -> None:
    compare("mhe-rti", MODELS[model], 12)
