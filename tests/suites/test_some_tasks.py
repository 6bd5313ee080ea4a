"""Some tasks of a suite, as notebooks run them: the same rows as the benchmark's, and verdicts."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmark.tasks.suite import Scope
from models.errors import InputError
from suites import SuiteRun, run_some
from suites.execute import execute
from suites.table import find_suite

CASE = "full turn"


@pytest.fixture(scope="module")
def swings() -> SuiteRun:
    return run_some("tilt", [(CASE, "*", "fixed-weight", 2), ("swing, * ax?s", "*", "ekf", 1)])


def test_what_is_wanted_runs_with_so_many_seeds(swings: SuiteRun) -> None:
    rows = swings.results.rows[["case", "estimator", "seed"]].drop_duplicates()
    ran = {tuple(row) for row in rows.itertuples(index=False)}
    weighed = {(CASE, "fixed-weight", seed) for seed in (0, 1)}
    swung = {(f"swing, {axes}", "ekf", 0) for axes in ("one axis", "two axes")}
    assert ran == weighed | swung
    assert swings.tasks == 4
    assert swings.failed == {}


def test_figures_are_those_of_the_benchmark(swings: SuiteRun) -> None:
    suite, scope = find_suite("tilt"), Scope(seeds=2)
    [task] = [
        t for t in suite.tasks(scope) if (t.case, t.estimator, t.seed) == (CASE, "fixed-weight", 1)
    ]
    wanted = {quantity.name: quantity.rmse for quantity in execute(task, scope).quantities}
    found = swings.results.select(case=CASE, estimator="fixed-weight", seed=1)
    np.testing.assert_equal(dict(zip(found["quantity"], found["rmse"], strict=True)), wanted)


def test_claims_without_runs_are_left_out(swings: SuiteRun) -> None:
    every = swings.verdicts()
    assert 0 < len(every) < 22
    assert set(every["source"].str.startswith("[Tilt]")) == {True, False}
    assert swings.verdicts(source="[Tilt]").equals(
        every[every["source"].str.startswith("[Tilt]")].reset_index(drop=True)
    )
    one = swings.verdicts(["tilt-5-*"])
    assert len(one) <= 1
    assert swings.verdicts(["nothing"]).empty


def test_a_figure_is_drawn_by_its_key(swings: SuiteRun) -> None:
    assert isinstance(swings.figure("tilt-axes"), Figure)
    with pytest.raises(InputError, match="figure nothing is unknown, expected one of"):
        swings.figure("nothing")


def test_nothing_wanted_is_refused() -> None:
    with pytest.raises(InputError, match="suite tilt has none of the wanted tasks"):
        run_some("tilt", [("no such case", "*", "*", 1)])
    with pytest.raises(InputError, match="suite tlit is unknown"):
        run_some("tlit", [("*", "*", "*", 1)])
