"""Choices of sensors that the seeds do not tell apart: on made-up rows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from benchmark.report.advice import WITHOUT, advice
from benchmark.report.content import Answer
from benchmark.report.in_short import headlines
from benchmark.report.matrix import Matrix
from benchmark.report.tied import Choice, tied
from tests.benchmark.report.test_advice import Runs, matrix, said

BEST, OTHER, THIRD = "two accelerometers", "accel+gyro", "gyro"


def names_of_tied(runs: Runs) -> list[str]:
    found = matrix(runs)
    best, *others = (Choice(sensors, name, found.cell(sensors, name)) for sensors, name in runs)
    return [choice.sensors for choice in tied(found, best, others)]


def test_a_clear_winner() -> None:
    runs = {(BEST, "ekf"): [1.0, 2.0, 3.0], (OTHER, "ekf"): [2.0, 4.1, 6.0]}
    assert names_of_tied(runs) == []


def test_what_differs_by_luck_of_the_seeds_is_tied() -> None:
    """Medians 0.93 and 1.43, and any of the seeds may have either above the other."""
    runs = {
        (BEST, "ekf"): [0.80, 0.93, 1.10, 0.95, 0.90],
        (OTHER, "ekf"): [1.43, 0.19, 2.22, 0.60, 1.60],
    }
    assert names_of_tied(runs) == [OTHER]


def test_one_seed_tells_nothing() -> None:
    assert names_of_tied({(BEST, "ekf"): [1.0], (OTHER, "ekf"): [9.0]}) == [OTHER]


def test_a_lost_seed_is_no_tie() -> None:
    runs = {(BEST, "ekf"): [1.0, 1.1, 0.9], (OTHER, "ekf"): [1.0, 1.05, np.inf]}
    assert names_of_tied(runs) == []


def test_errors_of_zero_are_compared() -> None:
    runs = {(BEST, "ekf"): [0.0, 0.0, 0.0], (OTHER, "ekf"): [0.0, 0.0, 0.0]}
    assert names_of_tied(runs) == [OTHER]
    assert names_of_tied({**runs, (OTHER, "ekf"): [1.0, 1.1, 1.2]}) == []


@pytest.mark.parametrize("choices", [2, 3, 8])
def test_the_limit_is_students_with_bonferroni(choices: int) -> None:
    """Just within SciPy's interval of so many it is tied, just beyond it is not."""
    noise = np.array([0.1, -0.3, 0.25, 0.0, 0.07])
    level = 1 - 2 * 0.05 / (choices - 1)  # it has two ends
    mean = noise.mean() - stats.ttest_1samp(noise, 0.0).confidence_interval(level).low
    best = np.array([1.0, 2.0, 0.5, 1.5, 3.0])
    more = {("camera", f"other {k}"): [50.0 * v for v in best] for k in range(choices - 2)}
    for factor, expected in ((1 - 1e-9, [OTHER]), (1 + 1e-9, [])):
        off = best * np.exp(noise - noise.mean() + mean * factor)
        found = names_of_tied({(BEST, "ekf"): list(best), (OTHER, "ekf"): list(off), **more})
        assert found == expected


@pytest.mark.slow
def test_the_true_best_is_rarely_excluded() -> None:
    """Of five that are the same but for luck, each is kept in 95 % of runs, whoever is first."""
    rng, trials = np.random.default_rng(0), 200
    names = [BEST, OTHER, THIRD, "camera", "accel"]
    kept = 0
    for _ in range(trials):
        errors = dict(zip(names, np.exp(0.3 * rng.standard_normal((5, 5))), strict=True))
        order = sorted(names, key=lambda name, e=errors: np.median(e[name]))  # type: ignore[misc]
        runs = {(name, "ekf"): list(errors[name]) for name in order}
        kept += THIRD in [order[0], *names_of_tied(runs)]
    assert kept >= stats.binom.ppf(0.001, trials, 0.95)


LUCK: Runs = {
    (OTHER, "ekf"): [1.43, 0.19, 2.22, 0.60, 1.60],
    (BEST, "ekf"): [0.80, 0.93, 1.10, 0.95, 0.90],
    ("gyro", "ekf"): [30.0, 31.0, 30.0, 32.0, 30.5],
}


def of_luck() -> Matrix:
    return matrix(LUCK)


def test_the_advice_names_cheaper_ones_that_may_be_as_good() -> None:
    """And not the gyroscope, which is surely worse."""
    found = advice(of_luck())
    assert said(found).startswith(f"Take {BEST} with ekf (0.930 deg)")
    assert "Not told apart from it by 5 seeds: accel+gyro; more seeds would tell." in said(found)
    pick = found.of(WITHOUT)
    assert pick is not None
    assert pick.as_good == (OTHER,)


def test_the_headlines_say_so() -> None:
    found = of_luck()
    assert headlines([Answer(found, advice(found))])[1] == (
        "By 5 seeds cheaper sensors are not surely worse for elevation without a camera "
        "(accel+gyro): more seeds would tell."
    )


def test_what_one_seed_does_not_tell_is_said_once_without_names() -> None:
    found = matrix({choice: [errors[0]] for choice, errors in LUCK.items()})
    assert headlines([Answer(found, advice(found))])[1] == (
        "One seed does not tell whether cheaper sensors are as good."
    )
    assert "accel+gyro" not in said(advice(found)).partition("Cheapest")[0]


def test_dearer_ones_are_not_named() -> None:
    runs = {**LUCK, (OTHER, "ekf"): [0.4, 0.5, 0.6, 0.45, 0.5], (BEST, "ekf"): [0.9, 0.4] * 2 + [1]}
    pick = advice(matrix(runs)).of(WITHOUT)
    assert pick is not None
    assert pick.sensors == OTHER
    assert pick.as_good == ()
