from __future__ import annotations

import numpy as np
import pytest

from models.errors import InputError
from models.turntable import turntable_model
from suites.tilt.cases import CASES, FULL_TURN, Installation, TiltCase
from suites.tilt.samples import (
    CONVERSION,
    SENSORS,
    case_named,
    installed,
    simulate_samples,
    tilt_tracker,
)
from suites.tilt.weights import TRAINING

REST = CASES["rest"]


def test_samples_come_through_the_converter() -> None:
    samples = simulate_samples(REST, 0)
    assert samples.counts.dtype.kind == "i"
    assert len(np.unique(samples.counts)) < samples.counts.size / 2, "whole counts repeat"
    np.testing.assert_array_equal(samples.acceleration_g, CONVERSION.acceleration_g(samples.counts))


@pytest.mark.parametrize(
    "installation", [Installation(), Installation(5.0, 1.0), Installation(1.0, 10.0)]
)
def test_noise_is_what_the_models_are_told(installation: Installation) -> None:
    case = TiltCase(REST.turn, installation)
    samples = simulate_samples(case, 1)
    model = turntable_model(installed(installation), SENSORS)
    gravity = tilt_tracker().gravity_m_s2
    found = [
        (gravity * (samples.acceleration_g - samples.direction)).std(),
        samples.rates.std(),
    ]
    told = [model.noise_std[0], model.noise_std[3]]
    # Of 3 × 1201 and 2 × 1201 values: a relative deviation of 1/√2n, three of them allowed.
    assert found == pytest.approx(told, rel=3 / np.sqrt(2 * 2 * 1201))


def test_a_bias_is_one_of_the_installation() -> None:
    biased = TiltCase(REST.turn, Installation(gyroscope_bias_deg_s=1.0))
    for seed in (0, 1):
        plain, moved = simulate_samples(REST, seed), simulate_samples(biased, seed)
        np.testing.assert_array_equal(plain.counts, moved.counts)
        np.testing.assert_allclose(moved.rates - plain.rates, np.radians(1.0), atol=1e-15)
    names = turntable_model(installed(biased.installation), SENSORS).state_names
    assert len(names) == 6, "and the models estimate it"


def test_no_estimator_is_given_the_truth() -> None:
    assert simulate_samples(REST, 0).recording(9.81).truth is None


def test_a_seed_is_a_recording_and_training_is_another() -> None:
    first, again = (simulate_samples(case_named(FULL_TURN), 0) for _ in range(2))
    np.testing.assert_array_equal(first.rates, again.rates)
    for other in (1, TRAINING):
        assert (simulate_samples(case_named(FULL_TURN), other).rates != first.rates).mean() > 0.9


def test_unknown_cases() -> None:
    with pytest.raises(InputError, match="case half turn is unknown, expected one of full turn"):
        case_named("half turn")
