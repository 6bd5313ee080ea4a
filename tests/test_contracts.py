"""Every model and every model × estimator pair of the registry keeps its contract."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import cache
from typing import Any

import numpy as np
import pytest

from benchmark.configurations import contract_models
from estimation.estimator import Estimator, run_measurements
from estimation.recording import Measurement, Recording
from mhe.arrival_cost import ARRIVAL_COSTS
from models.bundled import bundled_pens
from models.errors import InputError
from models.gaussian import GaussianState
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable
from pen_mhe.estimators import ESTIMATORS, create_estimator, settings_read
from recordings.simulate_pen import simulate
from recordings.simulate_turntable import simulate_table
from tests.contracts import check_failures, check_history, check_inputs_unchanged, check_model

DURATION_S = 0.15
MODELS = contract_models()
QUICK = {"horizon": 5}
QUICK_PENS = ("pen6 accel+gyro+camera", "pen5 accel+gyro+contact", "pen6 two accelerometers")
"""The pens that quick tests put under every estimator; all of them stand in the slow ones."""

pytestmark = pytest.mark.usefixtures("interpreted")


def quick(estimator: str, model: StateSpaceModel) -> Estimator[Any]:
    return create_estimator(estimator, model, **settings_read(estimator, QUICK))


@cache
def recording(body: str) -> Recording:
    """Return the recording of ``pen5``, ``pen6`` or ``turntable``, the first word of a name."""
    if body == "turntable":
        return simulate_table(paper_turntable(), DURATION_S + 0.3, seed=1)
    dof = {"pen5": 5, "pen6": 6}[body]
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": dof})
    return simulate(pen, None, motion="turn", duration_s=DURATION_S + 0.3, seed=1)


def measurements(name: str) -> list[Measurement]:
    model = MODELS[name]
    measured = [sensor.name for sensor in model.measured_sensors]
    source = recording(name.split()[0]).select(measured)
    moving = [m for m in source.measurements(model) if m.time_s >= 0.3]
    # A dropout: one instant without any reading.
    moving[5] = Measurement(moving[5].time_s, np.full(model.n_y, np.nan))
    return moving


@pytest.mark.parametrize("name", MODELS)
def test_model(name: str) -> None:
    check_model(MODELS[name], np.random.default_rng(0))


@pytest.mark.parametrize("pen", bundled_pens())
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_bundled_pen_with_all_its_sensors(pen: str, degrees_of_freedom: int) -> None:
    config = load_pen(pen).model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    check_model(pen_model(config), np.random.default_rng(0))


@pytest.mark.parametrize("room", ["ekf_baseline", "mhe"])
def test_every_estimator_is_in_the_registry(room: str) -> None:
    found = {
        value.name
        for module in pkgutil.iter_modules(importlib.import_module(room).__path__, f"{room}.")
        for value in vars(importlib.import_module(module.name)).values()
        if inspect.isclass(value) and all(hasattr(value, of) for of in ("name", "init", "step"))
    }
    assert found
    assert found <= set(ESTIMATORS)


def pairs() -> list[Any]:
    """Model and estimator; what iterates is slow as well, on all quick pens but the first."""
    iterates = ("mhe-ipopt", "mhe-sparse", "mhe")
    slow = {(pen, estimator) for pen in QUICK_PENS[1:] for estimator in iterates}
    return [
        pytest.param(name, estimator, marks=pytest.mark.slow if is_slow else ())
        for name in MODELS
        for estimator in ESTIMATORS
        for is_slow in [
            (name.startswith("pen") and name not in QUICK_PENS) or (name, estimator) in slow
        ]
    ]


@pytest.mark.parametrize(("name", "estimator"), pairs())
def test_history_and_determinism(name: str, estimator: str) -> None:
    steps, built = measurements(name), quick(estimator, MODELS[name])
    first = run_measurements(built, steps, covariances=True)
    check_history(MODELS[name], first, len(steps))
    again = run_measurements(built, steps, covariances=True)
    np.testing.assert_array_equal(first.mean, again.mean)
    np.testing.assert_array_equal(first.covariance, again.covariance)


@pytest.mark.parametrize(("name", "estimator"), pairs())
def test_inputs_unchanged_and_failures(name: str, estimator: str) -> None:
    built = quick(estimator, MODELS[name])
    steps = measurements(name)[:8]
    check_inputs_unchanged(built, steps)
    check_failures(built, steps)


@pytest.mark.parametrize("arrival_cost", ARRIVAL_COSTS)
def test_every_arrival_cost(arrival_cost: str) -> None:
    name = "pen6 accel+gyro+camera"
    steps = measurements(name)
    built = create_estimator("mhe-ipopt", MODELS[name], horizon=5, arrival_cost=arrival_cost)
    history = run_measurements(built, steps, covariances=True)
    check_history(MODELS[name], history, len(steps))
    assert history.solved_fraction == 1.0


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_prior_of_ones_own_is_the_model_with_that_prior(estimator: str) -> None:
    name = "turntable accel+gyro"
    model, some = MODELS[name], measurements(name)[:8]
    told = GaussianState(model.prior.mean + 0.1, 0.25 * model.prior.covariance)
    with_it = quick(estimator, model.replace(prior=told))
    expected = run_measurements(with_it, some, covariances=True)
    found = run_measurements(quick(estimator, model), some, prior=told, covariances=True)
    # The scaling of a solver may follow the model's own prior.
    np.testing.assert_allclose(found.mean, expected.mean, rtol=0, atol=1e-7)
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_prior_of_another_size_is_refused(estimator: str) -> None:
    system = quick(estimator, MODELS["turntable accel"])
    with pytest.raises(InputError, match=r"the prior mean has shape \(2,\), expected \(4,\)"):
        system.init(GaussianState(np.zeros(2), np.eye(2)))
