"""Contenders of the classics: others' where they are installed, and what the truth keeps to."""

from __future__ import annotations

import numpy as np
import pytest

from benchmark.tasks.suite import Scope
from suites.classics import do_mpc, suite
from suites.classics.do_mpc import DoMpcEstimator, rate_noise
from suites.classics.problems import PROBLEMS, figures_of
from suites.classics.recordings import model_of, prior_of, recorded
from suites.classics.suite import ALL_FROM, SUITE
from suites.peers import installed

peer = pytest.mark.skipif(not installed(do_mpc.NAME), reason="do-mpc is not installed")


@pytest.fixture
def _nothing_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite, "installed", lambda package: "")


@pytest.mark.usefixtures("_nothing_installed")
def test_without_do_mpc_it_is_left_out_with_a_reason() -> None:
    assert {task.estimator for task in SUITE.tasks(Scope(1))} == {
        "mhe-ipopt", "ukf", "mhe", "mhe-rti", "ekf",
    }  # fmt: skip
    assert SUITE.missing(Scope()) == (
        "suite classics: do-mpc left out, not installed (pip install pen-mhe[peers])"
    )


@peer
def test_do_mpc_runs_on_short_problems_and_on_all_of_them_from_a_hundred_seeds() -> None:
    def cases(n: int) -> list[str]:
        return [t.case for t in SUITE.tasks(Scope(n)) if t.estimator == do_mpc.NAME]

    assert set(PROBLEMS) - set(cases(5)) == {"damped_spring", "tank"}
    assert cases(5).count("rotating_masses") == 1
    assert len(cases(ALL_FROM)) == ALL_FROM * len(PROBLEMS)
    assert SUITE.missing(Scope()) == ""


@peer
def test_do_mpc_is_given_what_the_file_says() -> None:
    """Its estimates follow the discs, and nothing is left of the recording before."""
    case = "rotating_masses"
    contender, recording = DoMpcEstimator(case), recorded(case, 0)
    short = recording.first(1.5)
    found = contender.estimates(short, prior_of(case, recording, 0))
    again = contender.estimates(short, prior_of(case, recording, 0))
    np.testing.assert_array_equal(found.mean, again.mean)
    assert found.is_solved.all()
    assert found.is_finite.all()
    assert np.isnan(found.std).all()
    assert short.truth is not None
    errors = found.mean[-1, :3] - short.truth.values[len(found.mean) - 1, :3]
    assert np.abs(errors).max() < 3 * figures_of(case)["r"]
    assert found.mean[-1, 8] == pytest.approx(figures_of(case)["theta_1_true"], rel=0.5)


def test_noise_of_a_rate_is_that_of_a_step() -> None:
    given = figures_of("gas_2A_to_B")
    noise = rate_noise(PROBLEMS["gas_2A_to_B"], given)
    assert noise * given["dt_s"] == pytest.approx(given["q"])
    assert rate_noise(PROBLEMS["damped_spring"], figures_of("damped_spring")).tolist() == [0, 0.1]


@pytest.mark.parametrize("seed", range(10))
def test_the_truth_of_the_discs_keeps_to_its_bounds(seed: int) -> None:
    """Seeds 2, 4, 5 and 7 do not at the first draw."""
    model, truth = model_of("rotating_masses"), recorded("rotating_masses", seed).truth
    assert truth is not None
    assert (truth.values >= model.lower).all()
    assert (truth.values <= model.upper).all()


def test_what_is_known_of_the_set_points_is_off_by_their_noise() -> None:
    case, apart = "rotating_masses", []
    for seed in range(5):
        known = np.array(list(recorded(case, seed).inputs.values())).T
        steps = np.diff(known, axis=0)
        still = np.abs(steps) < 0.02
        apart.append(steps[still])
    std = np.concatenate(apart).std()
    assert std == pytest.approx(1e-2 / np.sqrt(20) * np.sqrt(2), rel=0.1)


def test_the_rod_of_the_truth_keeps_its_length() -> None:
    truth = recorded("pendulum_on_cart", 1).truth
    assert truth is not None
    assert set(truth.values[:, -1]) == {figures_of("pendulum_on_cart")["length_m"]}


def test_the_springs_prior_is_drawn_about_the_truth() -> None:
    case, away = "damped_spring", []
    for seed in range(6):
        recording = recorded(case, seed)
        assert recording.truth is not None
        away.append(prior_of(case, recording, seed).mean - recording.truth.values[0])
    assert np.std(away) == pytest.approx(0.01, rel=0.5)
