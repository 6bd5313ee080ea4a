"""Differentiators: exact where they must be, and blind to what has not arrived yet."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_filter

from classical_baseline.differentiators import (
    DIFFERENTIATORS,
    Differentiator,
    savitzky_golay,
)
from models.errors import InputError
from tests.classical_baseline.gestures import order

EXACT_FOR = {
    "backward": 1,
    "central": 2,
    "savitzky-golay": 2,
    "savitzky-golay-31": 3,
    "savitzky-golay-centred": 2,
}
"""Differentiator → degree of the polynomials whose slope it gives exactly."""

LOOKS_AHEAD = {"central": 1, "savitzky-golay-centred": 7}


@pytest.mark.parametrize("name", DIFFERENTIATORS)
def test_polynomials_are_differentiated_exactly(name: str) -> None:
    t = np.arange(50) * 0.1
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.7, 0.3][: EXACT_FOR[name] + 1])
    found = DIFFERENTIATORS[name](polynomial(t), 0.1)
    known = np.isfinite(found)
    assert known.sum() == 50 - len(DIFFERENTIATORS[name].weights) + 1
    np.testing.assert_allclose(found[known], polynomial.deriv()(t)[known], atol=1e-11)


@pytest.mark.parametrize("name", DIFFERENTIATORS)
def test_the_error_falls_with_the_step_as_the_degree_says(name: str) -> None:
    errors = []
    for step in (0.01, 0.005, 0.0025):
        t = np.arange(0, 2, step)
        found = DIFFERENTIATORS[name](np.sin(3 * t), step)
        at = round(1.0 / step)
        errors.append(abs(found[at] - 3 * np.cos(3.0)))
    assert (order(errors) > EXACT_FOR[name] - 0.15).all()


@pytest.mark.parametrize("name", DIFFERENTIATORS)
def test_only_those_that_say_so_use_the_future(name: str) -> None:
    differentiator, rng = DIFFERENTIATORS[name], np.random.default_rng(0)
    past = rng.standard_normal(60)
    changed = past.copy()
    changed[40:] += 1.0
    before, after = differentiator(past, 0.1), differentiator(changed, 0.1)
    first = int(np.flatnonzero(np.nan_to_num(before) != np.nan_to_num(after))[0])
    assert 40 - first == differentiator.ahead == LOOKS_AHEAD.get(name, 0)
    assert ("ahead" in differentiator.label) == (differentiator.ahead > 0)


def test_the_centred_one_is_that_of_scipy() -> None:
    values = np.random.default_rng(3).standard_normal(40)
    found = DIFFERENTIATORS["savitzky-golay-centred"](values, 0.05)
    expected = savgol_filter(values, 15, 2, deriv=1, delta=0.05)
    np.testing.assert_allclose(found[7:-7], expected[7:-7], atol=1e-11)


def test_the_causal_one_is_the_slope_of_a_fit_at_its_end() -> None:
    values = np.random.default_rng(4).standard_normal(15)
    fit = np.polynomial.Polynomial.fit(np.arange(15) * 0.2, values, 2)
    found = DIFFERENTIATORS["savitzky-golay"](values, 0.2)
    assert found[-1] == pytest.approx(fit.deriv()(14 * 0.2), rel=1e-10)
    assert np.isnan(found[:-1]).all()


@pytest.mark.parametrize("name", DIFFERENTIATORS)
def test_white_noise_grows_by_the_norm_of_the_weights(name: str) -> None:
    differentiator = DIFFERENTIATORS[name]
    noise = np.random.default_rng(5).standard_normal(200_000)
    found, expected = np.nanstd(differentiator(noise, 1.0)), np.linalg.norm(differentiator.weights)
    assert found == pytest.approx(expected, rel=0.02)


def test_too_few_samples_have_no_derivative() -> None:
    for differentiator in DIFFERENTIATORS.values():
        assert np.isnan(differentiator(np.ones(len(differentiator.weights) - 1), 0.1)).all()
        assert len(differentiator(np.zeros(0), 0.1)) == 0


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="order 5 over 5 points"):
        savitzky_golay(5, 5, 0)
    with pytest.raises(InputError, match="looks 2 samples ahead, expected 0 to 1"):
        Differentiator("wrong", (1.0, -1.0), 2)
