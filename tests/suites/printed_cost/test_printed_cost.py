"""What the printed errors cost: the same motion and readings for every model."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.tasks.task import Outcome, Quantity
from estimation.estimator import run
from estimation.recording import Recording
from models.arrays import Array
from models.pen import pen_model
from models.printed import PRINTED_ERRORS
from models.state_space import StateSpaceModel
from pen_mhe.errors import root_mean_square, state_errors
from pen_mhe.estimators import create_estimator
from suites.printed_cost.run import (
    AS_PRINTED,
    CONFIGURATIONS,
    MODELS,
    RIGID_BODY,
    SETTLING_S,
    CostCase,
    accelerometer_error,
    paper_pen,
    run_cost,
    simulated,
)
from tests.references import pen_readings

SEEDS, DURATION_S, R = (3, 4), 1.4, 0.1
pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulated(speed=1.0, seed=SEEDS[0], duration_s=DURATION_S)


def model_of(name: str, speed: float = 1.0) -> StateSpaceModel:
    return pen_model(paper_pen(MODELS[name], speed), ("accel", "gyro", "camera"))


def true_states(recording: Recording, time_s: Array) -> Array:
    assert recording.truth is not None
    rows = np.searchsorted(recording.truth.time_s, time_s)
    np.testing.assert_allclose(recording.truth.time_s[rows], time_s, atol=1e-9)
    return recording.truth.values[rows]


def test_the_pen_is_the_paper_s() -> None:
    """State (1) and readings (9)."""
    model = pen_model(paper_pen(PRINTED_ERRORS), ("accel", "gyro"), writing_area=False)
    assert (model.n_x, model.n_y) == (15, 5)
    assert paper_pen(PRINTED_ERRORS).printed_errors == PRINTED_ERRORS
    assert paper_pen().printed_errors == ()


def test_the_rigid_body_is_simulated(recording: Recording) -> None:
    """Readings differ from the rigid body's by the sensor's noise, at a fast pen too."""
    fast = simulated(speed=4.0, seed=SEEDS[0], duration_s=DURATION_S)
    noise_std = model_of(RIGID_BODY).sensor("accel").noise_std
    for played in (recording, fast):
        times, values = played.sensor("accel")
        noise = values - pen_readings.accelerometer(true_states(played, times), R)
        # Standard error of a variance from n samples: √(2/n); 4 of them, fixed seed.
        assert abs(np.mean((noise / noise_std) ** 2) - 1) < 4 * np.sqrt(2 / noise.size)


def test_played_faster_the_errors_grow_by_the_square(recording: Recording) -> None:
    """Twice as fast, at half the time: the same place, four times every acceleration.

    So with the errors: each is a product of two rates, or an acceleration.
    """
    fast = simulated(speed=2.0, seed=SEEDS[0], duration_s=DURATION_S / 2)
    times = fast.sensor("accel")[0]
    faster, slower = true_states(fast, times), true_states(recording, 2 * times)
    np.testing.assert_allclose(faster[:, :5], slower[:, :5], atol=1e-12)
    for name in MODELS:
        h, rigid = (model_of(model).sensor("accel").h for model in (name, RIGID_BODY))
        errors = [(h(x.T) - rigid(x.T)).full() for x in (faster, slower)]
        np.testing.assert_allclose(errors[0], 4 * errors[1], rtol=1e-9, atol=1e-11)
        assert (np.abs(errors[0]).max() > 1e-3) == (name != RIGID_BODY)


def test_all_errors_are_the_sum_of_each(recording: Recording) -> None:
    errors = {
        name: accelerometer_error(model_of(name), model_of(RIGID_BODY), recording)
        for name in MODELS
    }
    each = sum(errors[f"{error} only"] for error in PRINTED_ERRORS)
    np.testing.assert_allclose(errors[AS_PRINTED], each, atol=1e-12)


@pytest.fixture(scope="module")
def outcomes() -> dict[tuple[str, str, int], Outcome]:
    """Sensors, model and seed → what a run at the motion's own speed found."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("estimation.native.compiler", lambda: None)
        return {
            (sensors, model, seed): run_cost(CostCase(1.0, sensors, model), seed, DURATION_S)
            for sensors in CONFIGURATIONS
            for model in MODELS
            for seed in SEEDS
        }


def named(outcome: Outcome) -> dict[str, Quantity]:
    return {quantity.name: quantity for quantity in outcome.quantities}


def test_only_what_a_camera_shows_needs_one(
    outcomes: dict[tuple[str, str, int], Outcome],
) -> None:
    for (sensors, _, _), outcome in outcomes.items():
        quantities = named(outcome)
        seen = {name for name, quantity in quantities.items() if quantity.observable}
        blind = set() if sensors == "with camera" else {"tip", "azimuth"}
        assert set(quantities) - seen == blind
        assert {"elevation", "tip speed", "accelerometer error", "accelerometer noise"} <= seen
        assert outcome.solved_fraction == 1.0


def test_errors_of_the_models_are_what_a_run_finds(
    outcomes: dict[tuple[str, str, int], Outcome],
) -> None:
    """RMS length over all instants of the errors above; and the speed of the true tip."""
    rigid, models = model_of(RIGID_BODY), {name: model_of(name) for name in MODELS}
    for seed in SEEDS:
        played = simulated(1.0, seed, DURATION_S)
        assert played.truth is not None
        names = [f"tip_{axis}_velocity_m_s" for axis in "xyz"]
        speed = np.linalg.norm(played.truth.states(names, played.truth.time_s), axis=1)
        for name, model in models.items():
            length = np.linalg.norm(accelerometer_error(model, rigid, played), axis=1)
            for sensors in CONFIGURATIONS:
                found = named(outcomes[sensors, name, seed])
                error, tip = found["accelerometer error"], found["tip speed"]
                assert error.rmse == pytest.approx(np.sqrt(np.mean(length**2)), rel=1e-12)
                assert tip.rmse == pytest.approx(1e3 * np.sqrt(np.mean(speed**2)), rel=1e-12)


def test_errors_of_the_estimate_leave_out_its_begin(
    outcomes: dict[tuple[str, str, int], Outcome],
) -> None:
    model = model_of(AS_PRINTED)
    for seed in SEEDS:
        recording = simulated(1.0, seed, DURATION_S).select(["accel", "gyro", "camera"])
        history = run(create_estimator("ekf", model), recording)
        assert recording.truth is not None
        errors = state_errors(model, history, recording.truth)[history.time_s >= SETTLING_S]
        expected = root_mean_square(
            history.names, errors, {"mm": (("tip_x_m", "tip_y_m", "tip_z_m"), 1e3)}
        )
        found = named(outcomes["with camera", AS_PRINTED, seed])
        assert found["tip"].rmse == pytest.approx(expected["mm"], rel=1e-12)


def test_the_tip_pays_for_e2_and_e3_not_for_e4(
    outcomes: dict[tuple[str, str, int], Outcome],
) -> None:
    tip = {
        model: np.mean([named(outcomes["with camera", model, seed])["tip"].rmse for seed in SEEDS])
        for model in MODELS
    }
    assert tip["E2 only"] > 2 * tip[RIGID_BODY]
    assert tip["E3 only"] > 2 * tip[RIGID_BODY]
    assert tip["E4 only"] == pytest.approx(tip[RIGID_BODY], rel=0.05)
