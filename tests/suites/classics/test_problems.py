"""The classics: every problem read from one file, nothing set but N, criteria older than runs."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from benchmark.tasks.suite import Scope
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.written import criteria_written
from suites.classics.problems import PROBLEMS, figures_of, model_of, recorded, settings
from suites.classics.run import SUCCESS, WITHIN
from suites.classics.suite import ALL_FROM, ESTIMATORS, SLOW, SUITE

FIRST_RUN = "68e3276"
"""The commit whose tree ran first."""


@pytest.mark.parametrize("case", PROBLEMS)
def test_a_problem_is_what_the_file_says(case: str) -> None:
    given, model, recording = figures_of(case), model_of(case), recorded(case, 3)
    assert len(recording.time_s) == given["samples"]
    assert np.diff(recording.time_s) == pytest.approx(given["dt_s"])
    assert model.prior.mean.tolist() == np.atleast_1d(given["prior"]["mean"]).tolist()
    assert recording.truth is not None
    assert recording.truth.values[0] == pytest.approx(given["truth"])
    assert settings(case) == {"horizon": given["N"]}
    assert np.isfinite(recording.readings["reading"]).all()


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
        return sum(t.estimator == SLOW for t in SUITE.tasks(Scope(n))) // len(PROBLEMS)

    assert (seeds(5), seeds(20), seeds(ALL_FROM)) == (1, 5, ALL_FROM)
    assert len(ESTIMATORS) == 4


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_no_criterion_is_younger_than_the_first_run() -> None:
    assert SUITE.claims is not None
    written = criteria_written(SUITE.claims)
    if not written:
        pytest.skip("no checkout")
    known = ["git", "cat-file", "-e", f"{FIRST_RUN}^{{commit}}"]
    if subprocess.run(known, cwd=SUITE.claims.parent, check=False, capture_output=True).returncode:
        pytest.skip(f"commit {FIRST_RUN} is not in this checkout's history")
    for claim in load_claims(SUITE.claims):
        commit = written[claim.id].commit
        command = ["git", "merge-base", "--is-ancestor", commit or "HEAD", FIRST_RUN]
        older = subprocess.run(command, cwd=SUITE.claims.parent, check=False).returncode == 0
        assert (commit and older) or claim.changed, claim.id
