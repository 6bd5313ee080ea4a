"""Bad starts: wrong by what is stated, told honestly, and judged over the first second."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import suites.bad_starts.run as bad_starts
from estimation.estimator import run_measurements
from models.errors import InputError
from models.gaussian import GaussianState
from models.motions import sample_motion
from models.priors import replaced_prior
from pen_mhe.estimators import create_estimator
from recordings.motion_list import DRAWN
from suites.bad_starts.cases import (
    CASES,
    FROM_REST,
    KNOWLEDGE,
    REST_S,
    BadStart,
    case_model,
    case_named,
    case_pen,
    case_recording,
    strokes_from_rest,
)
from suites.bad_starts.run import (
    ESTIMATORS,
    BadStartRun,
    axis_elevation,
    body_rates,
    run_bad_start,
    summary,
)
from tests.linear_models import coupled_system, irregular_times
from tests.references import pen_readings

ELEVATION = "elevation_rad"
MOVING = {
    "velocity": ("tip_x_velocity_m_s", "tip_y_velocity_m_s", "tip_z_velocity_m_s"),
    "rate": ("azimuth_rate_rad_s", "elevation_rate_rad_s", "spin_rate_rad_s"),
    "acceleration": ("tip_x_acceleration_m_s2", "tip_y_acceleration_m_s2"),
    "angle acceleration": ("azimuth_acceleration_rad_s2", "elevation_acceleration_rad_s2"),
}


class HandedOverError(Exception):
    """Ends a run once it is known what the estimator is given."""


def what_the_estimator_is_given(
    case: BadStart, seed: int, monkeypatch: pytest.MonkeyPatch
) -> tuple[Any, Any]:
    """Return the prior and the recording that an estimator is driven with."""

    def stop(estimator: Any, recording: Any, prior: Any) -> None:
        raise HandedOverError(prior, recording)

    monkeypatch.setattr(bad_starts, "_kept", lambda case, estimator: None)
    monkeypatch.setattr(bad_starts, "run", stop)
    with pytest.raises(HandedOverError) as handed:
        run_bad_start(case, "ekf", seed)
    return handed.value.args  # type: ignore[return-value]


@pytest.mark.parametrize("name", CASES)
def test_the_start_is_wrong_by_what_is_stated_and_nothing_else_is_told(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = CASES[name]
    own = case_model(case)
    for seed in (1, 2):
        told, recording = what_the_estimator_is_given(case, seed, monkeypatch)
        assert recording.truth is None
        column = own.state_names.index(ELEVATION)
        truth = case_recording(case, seed).truth
        assert truth is not None
        error = told.mean[column] - truth.states([ELEVATION], truth.time_s[:1])[0, 0]
        assert abs(error) == pytest.approx(case.wrong_rad, abs=1e-12)
        honest = max(case.wrong_rad, 0.1) if case.told_std_rad is None else case.told_std_rad
        assert told.std[column] == pytest.approx(honest, rel=1e-12)
        others = np.arange(own.n_x) != column
        np.testing.assert_array_equal(told.mean[others], own.prior.mean[others])
        np.testing.assert_array_equal(
            told.covariance[np.ix_(others, others)],
            own.prior.covariance[np.ix_(others, others)],
        )


def test_a_seed_is_one_start_for_every_estimator_and_both_signs_come() -> None:
    case = CASES["gesture-0.5"]
    starts = [run_bad_start(case, "ekf", seed).start_error_rad for seed in range(8)]
    assert set(starts) == {-0.5, 0.5}
    assert [run_bad_start(case, "mhe-rti", seed).start_error_rad for seed in (0, 7)] == [
        starts[0],
        starts[7],
    ]
    np.testing.assert_array_equal(
        case_recording(case, 3).readings["accel_lower"],
        case_recording(CASES["gesture-1"], 3).readings["accel_lower"],
    )


def test_a_run_is_reproducible() -> None:
    first, again = (run_bad_start(CASES["gesture-0.5"], "ekf", 7) for _ in range(2))
    np.testing.assert_array_equal(first.elevation_error, again.elevation_error)
    np.testing.assert_array_equal(first.rate_error, again.rate_error)


def test_on_a_linear_model_no_start_is_bad_for_one_and_good_for_another() -> None:
    """Twenty deviations off: EKF, one pass and all passes are the same Kalman filter."""
    system, rng = coupled_system(3), np.random.default_rng(8)
    measurements = system.simulate(irregular_times(40, rng), rng)
    mean, std = system.model.prior.mean, system.model.prior.std
    wrong = {name: mean[i] + 20 * std[i] for i, name in enumerate(system.model.state_names[:2])}
    prior = replaced_prior(system.model, wrong, float(std[0]))
    ekf, *others = (
        run_measurements(create_estimator(name, system.model), measurements, prior=prior)
        for name in ESTIMATORS
    )
    right = run_measurements(create_estimator("ekf", system.model), measurements)
    assert np.abs(ekf.mean[0] - right.mean[0]).max() > std[0]
    for other in others:
        np.testing.assert_allclose(other.mean / ekf.std, ekf.mean / ekf.std, rtol=0, atol=1e-9)
        np.testing.assert_allclose(other.std, ekf.std, rtol=1e-9)


def test_a_prior_of_some_states_leaves_the_others_alone() -> None:
    model = coupled_system(3).model
    root = np.random.default_rng(1).standard_normal((model.n_x, model.n_x))
    P = root @ root.T + np.eye(model.n_x)
    model = model.replace(prior=GaussianState(np.arange(float(model.n_x)), P))
    name = model.state_names[1]
    prior = replaced_prior(model, {name: 9.0}, 0.3)
    expected = np.arange(float(model.n_x))
    expected[1] = 9.0
    np.testing.assert_array_equal(prior.mean, expected)
    others = np.arange(model.n_x) != 1
    np.testing.assert_array_equal(
        prior.covariance[np.ix_(others, others)], P[np.ix_(others, others)]
    )
    assert prior.covariance[1, 1] == pytest.approx(0.09, rel=1e-15)
    assert not prior.covariance[1, others].any()
    assert not prior.covariance[others, 1].any()
    np.testing.assert_array_equal(model.prior.covariance, P)


def test_body_rates_are_those_of_the_textbook() -> None:
    states = np.random.default_rng(2).standard_normal((20, 15))
    five = case_pen(CASES["no-spin-0.5"])
    assert five.degrees_of_freedom == 5
    np.testing.assert_allclose(body_rates(five, states), pen_readings.gyroscope(states), atol=1e-12)
    six = np.zeros((20, 18))
    six[:, :5], six[:, 6:11], six[:, 11] = states[:, :5], states[:, 5:10], 0.7
    expected = pen_readings.gyroscope(states) + np.array([0, 0, 0.7])
    np.testing.assert_allclose(body_rates(case_pen(CASES["writing-1"]), six), expected, atol=1e-12)


def test_the_axis_is_as_high_seen_from_the_other_side() -> None:
    theta = np.linspace(-1.5, 1.5, 31)
    np.testing.assert_allclose(axis_elevation(theta), theta, atol=1e-12)
    np.testing.assert_allclose(axis_elevation(math.pi - theta), theta, atol=1e-12)


def test_strokes_start_at_rest_and_differ_by_seed() -> None:
    times = np.arange(0, 3, 0.01)
    first, again, other = (sample_motion(strokes_from_rest(seed), times) for seed in (3, 3, 4))
    resting = times < REST_S
    assert not first.q_dot[resting].any()
    assert not first.q_ddot[resting].any()
    assert np.abs(first.q_dot[~resting]).max(axis=0).min() > 0.01
    np.testing.assert_array_equal(first.q, again.q)
    assert np.abs(first.q[-1] - other.q[-1]).min() > 1e-4


@pytest.mark.parametrize("name", ["gentle-1", "writing-1"])
def test_what_is_told_of_a_writing_hand_covers_it(name: str) -> None:
    """True starts in deviations of the prior: of one size where told, smaller in the pen file."""
    case, model = CASES[name], case_model(CASES[name])
    truths = [case_recording(case, seed).truth for seed in range(30)]
    for states in MOVING.values():
        index = [model.state_names.index(state) for state in states]
        start = [truth.states(states, truth.time_s[:1])[0] for truth in truths if truth is not None]
        size = np.sqrt(np.mean((np.array(start) / model.prior.std[index]) ** 2))
        assert size < 1.5
        assert (size > 0.3) == (name == "gentle-1")


@pytest.mark.parametrize("name", [name for name in CASES if name.endswith("-0.5")])
def test_a_hand_told_to_rest_does_rest(name: str) -> None:
    case = CASES[name]
    rests = KNOWLEDGE[case.knowledge].prior.get("velocity_std_m_s") == 0.001
    assert rests == (case.motion in ("still", FROM_REST, DRAWN))
    if rests:
        model, truth = case_model(case), case_recording(case, 5).truth
        assert truth is not None
        moving = [s for states in MOVING.values() for s in states if s in model.state_names]
        std = model.prior.std[[model.state_names.index(state) for state in moving]]
        assert (np.abs(truth.states(moving, truth.time_s[:1])[0]) < 4 * std).all()


def test_without_bias_there_is_no_bias_state() -> None:
    assert any("bias" in name for name in case_model(CASES["held-0.5"]).state_names)
    assert not any("bias" in name for name in case_model(CASES["unbiased-0.5"]).state_names)


def made_up_run(size: float, end: float) -> BadStartRun:
    """Return a run of 2 s whose error is `size` in the first second and `end` afterwards."""
    time_s = 4.0 + np.arange(201) / 100
    error = np.where(time_s <= 5.0 + 1e-9, size, end)
    return BadStartRun(0, 0.5, time_s, -error, np.full(201, 0.1), 2 * error, 0.5)


def test_the_summary_takes_the_first_second_and_the_last_instant() -> None:
    runs = [made_up_run(k, end) for k, end in ((1.0, 0.01), (2.0, 0.05), (3.0, 0.2), (4.0, 0.3))]
    row = summary(CASES["writing-0.5"], "ekf", runs)
    assert row["runs"] == 4
    assert row["elevation_rms_rad_median"] == pytest.approx(2.5)
    assert row["elevation_rms_rad_p90"] == pytest.approx(3.7)
    assert row["rate_rms_rad_s_median"] == pytest.approx(5.0)
    assert row["end_elevation_rad_median"] == pytest.approx(0.125)
    assert (row["within_1_deg"], row["within_5_deg"]) == (0.25, 0.5)
    assert row["end_error_per_std"] == pytest.approx(1.25)
    assert row["solved"] == 0.5


def test_an_ekf_carries_a_bad_start_and_an_mhe_forgets_it() -> None:
    """Half a radian or one: the same MHE to a twentieth, twice the error for the EKF."""
    median = {
        (name, estimator): np.median(
            [
                (run := run_bad_start(CASES[name], estimator, seed)).first_rms(run.elevation_error)
                for seed in range(6)
            ]
        )
        for name in ("gentle-0.5", "gentle-1")
        for estimator in ("ekf", "mhe")
    }
    assert median["gentle-1", "ekf"] > 2 * median["gentle-0.5", "ekf"]
    assert median["gentle-1", "mhe"] == pytest.approx(median["gentle-0.5", "mhe"], rel=0.05)
    assert median["gentle-1", "ekf"] > 5 * median["gentle-1", "mhe"]


def test_an_unknown_case_is_refused() -> None:
    with pytest.raises(InputError, match="case worse is unknown, expected one of writing-0, "):
        case_named("worse")
