"""The classics: every problem read from one file, nothing set but N, criteria older than runs."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from benchmark.from_mhe import REFERENCE
from benchmark.tasks.suite import Scope
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.written import criteria_written
from suites.classics.problems import PROBLEMS, figures_of
from suites.classics.recordings import model_of, recorded, settings
from suites.classics.run import SUCCESS, WITHIN
from suites.classics.suite import ALL_FROM, CONTENDERS, SUITE

FIRST_RUN = {
    **dict.fromkeys(("gas_2A_to_B", "gas_A_B_C", "van_der_pol", "tank"), "68e3276"),
    **dict.fromkeys(("rotating_masses", "pendulum_on_cart", "damped_spring"), "506252a"),
}
"""Case → the commit whose tree ran it first."""


@pytest.mark.parametrize("case", PROBLEMS)
def test_a_problem_is_what_the_file_says(case: str) -> None:
    given, model, recording = figures_of(case), model_of(case), recorded(case, 3)
    assert len(recording.time_s) == given["samples"]
    assert np.diff(recording.time_s) == pytest.approx(given["dt_s"])
    assert recording.truth is not None
    assert model.noise_std == pytest.approx(np.broadcast_to(given["r"], model.n_y))
    assert settings(case) == {"horizon": given["N"]}
    assert np.isfinite(recording.readings["reading"]).all()
    assert set(recording.inputs) == set(PROBLEMS[case].inputs)


@pytest.mark.parametrize("case", ["gas_2A_to_B", "gas_A_B_C", "van_der_pol", "tank"])
def test_prior_and_start_of_a_whole_state_are_the_files(case: str) -> None:
    given, model, truth = figures_of(case), model_of(case), recorded(case, 3).truth
    assert model.prior.mean.tolist() == np.atleast_1d(given["prior"]["mean"]).tolist()
    assert truth is not None
    assert truth.values[0] == pytest.approx(given["truth"])


def test_the_noise_of_a_step_is_the_files() -> None:
    given, model = figures_of("gas_2A_to_B"), model_of("gas_2A_to_B")
    x, rest, dt = np.array([3.0, 1.0]), np.zeros(2), given["dt_s"]
    moved = model.f(x, np.ones(2), dt).full() - model.f(x, rest, dt).full()
    assert moved.ravel() == pytest.approx(given["q"])


def test_a_moving_horizon_finds_what_the_filter_loses() -> None:
    tasks = {t.estimator: t for t in SUITE.tasks(Scope(1)) if t.case == "gas_2A_to_B"}
    found = {
        name: {q.name: q.bias for q in SUITE.run(tasks[name], Scope(1)).quantities}
        for name in ("ekf", "mhe")
    }
    assert (found["ekf"][SUCCESS], found["mhe"][SUCCESS]) == (0.0, 1.0)
    assert found["ekf"][WITHIN] < 0.5


def test_the_slow_one_runs_on_all_of_a_hundred_seeds() -> None:
    def seeds(n: int) -> int:
        return sum(t.estimator == REFERENCE for t in SUITE.tasks(Scope(n))) // len(PROBLEMS)

    assert (seeds(5), seeds(20), seeds(ALL_FROM)) == (1, 5, ALL_FROM)
    assert [row.name for row in CONTENDERS] == [
        "mhe-ipopt",
        "do-mpc",
        "ukf",
        "mhe",
        "mhe-rti",
        "ekf",
    ]


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_no_criterion_is_younger_than_the_first_run() -> None:
    assert SUITE.claims is not None
    folder = SUITE.claims.parent
    written = criteria_written(SUITE.claims)
    if not written:
        pytest.skip("no checkout")
    for claim in load_claims(SUITE.claims):
        commit, first = written[claim.id].commit, FIRST_RUN[str(claim.of["case"])]
        known = ["git", "cat-file", "-e", f"{first}^{{commit}}"]
        if subprocess.run(known, cwd=folder, check=False, capture_output=True).returncode:
            pytest.skip(f"commit {first} is not in this checkout's history")
        command = ["git", "merge-base", "--is-ancestor", commit or "HEAD", first]
        older = subprocess.run(command, cwd=folder, check=False).returncode == 0
        assert (commit and older) or claim.changed, claim.id
