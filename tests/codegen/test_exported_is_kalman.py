"""On a linear model every export is the textbook Kalman filter, in either form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from tests.codegen.exports import FORMS, exported, told
from tests.engines import needs_compiler
from tests.linear_models import (
    LinearSystem,
    constant_acceleration_system,
    coupled_system,
    irregular_times,
)
from tests.references import kalman

pytestmark = needs_compiler

SYSTEMS = {"one axis": constant_acceleration_system(1), "coupled": coupled_system(3)}
PER_STEP = {"double": 1e-12, "float": 1e-4}
RESOLUTION = {"double": 0.0, "float": 4 * float(np.finfo(np.float32).eps)}
"""Of a state itself, which may lie many standard deviations from zero."""
DOUBLE = [form for real, form in FORMS if real == "double"]


def error(estimate: Estimate, wanted: kalman.Posterior) -> float:
    """Largest deviation of an estimate and its innovation, in standard deviations."""
    rows, std = wanted.rows, np.sqrt(np.diag(wanted.covariance))
    std_v = np.sqrt(np.diag(wanted.innovation_covariance))
    S = estimate.innovation_covariance[np.ix_(rows, rows)]
    parts = (
        (estimate.state.mean - wanted.mean) / std,
        (estimate.state.covariance - wanted.covariance) / np.outer(std, std),
        (estimate.innovation[rows] - wanted.innovation) / std_v,
        (S - wanted.innovation_covariance) / np.outer(std_v, std_v),
    )
    return float(max(np.abs(part).max(initial=0) for part in parts))


def next_posterior(
    system: LinearSystem, estimate: Estimate | None, measurement: Measurement
) -> kalman.Posterior:
    """Return the textbook's step from an estimate, from the prior for None."""
    x, P = system.model.prior.mean, system.model.prior.covariance
    if estimate is not None:
        dt = measurement.time_s - estimate.time_s
        state = estimate.state
        x, P = kalman.predict(state.mean, state.covariance, system.F(dt), system.Q(dt))
    return kalman.update(x, P, measurement.y, system.H, system.R)


@pytest.mark.cover
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("system_name", SYSTEMS)
@pytest.mark.parametrize(("real", "form"), FORMS)
def test_each_step_is_the_textbooks(name: str, system_name: str, real: str, form: str) -> None:
    system, rng = SYSTEMS[system_name], np.random.default_rng(11)
    measurements = system.simulate(irregular_times(150, rng), rng, missing=0.4)
    before = None
    for measurement, estimate in zip(
        measurements,
        told(exported(name, system.model, real, form), measurements),
        strict=True,
    ):
        wanted = next_posterior(system, before, measurement)
        resolved = RESOLUTION[real] * np.abs(wanted.mean / np.sqrt(np.diag(wanted.covariance)))
        assert error(estimate, wanted) < PER_STEP[real] + resolved.max()
        assert estimate.status is (Status.SOLVED if len(wanted.rows) else Status.NO_READING)
        before = estimate


@pytest.mark.slow
@pytest.mark.parametrize("form", DOUBLE)
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_after_ten_thousand_steps(name: str, form: str) -> None:
    system, rng = SYSTEMS["coupled"], np.random.default_rng(12)
    measurements = system.simulate(irregular_times(10_000, rng), rng, missing=0.4)
    settings = {"horizon": 5} if name == "mhe-rti" else None
    estimates = told(exported(name, system.model, "double", form, settings), measurements)
    wanted = system.textbook(measurements)
    assert max(error(a, b) for a, b in zip(estimates, wanted, strict=True)) < 1e-9


@pytest.mark.parametrize("form", DOUBLE)
def test_two_states_take_turns(form: str) -> None:
    """They share one workspace, and nothing of it passes from one to the other."""
    system, rng = SYSTEMS["coupled"], np.random.default_rng(13)
    times = irregular_times(40, rng)
    runs = [system.simulate(times + later, rng, missing=0.2) for later in (0.0, 5.0)]
    estimator = exported("mhe-rti", system.model, "double", form)
    alone = [told(estimator, run) for run in runs]
    states = [estimator.init(), estimator.init()]
    for k in range(len(times)):
        for i, run in enumerate(runs):
            states[i], estimate = estimator.step(states[i], run[k])
            np.testing.assert_array_equal(estimate.state.mean, alone[i][k].state.mean)
            kept = replace(estimate.state, mean=alone[i][k].state.mean)
            np.testing.assert_array_equal(kept.covariance, alone[i][k].state.covariance)
