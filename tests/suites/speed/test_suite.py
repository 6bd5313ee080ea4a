"""The suite: who takes part, one race for all of a case, claims that rows can answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import Any

import pytest

from benchmark.tasks.suite import Scope
from benchmark.tasks.task import FAILED, Task
from benchmark.verdicts.claims import Claim, load_claims
from models.errors import InputError
from suites.speed import suite as suite_module
from suites.speed.cases import CASES, SpeedCase
from suites.speed.contender import BATCH, STEP, Entry
from suites.speed.outcomes import LEAST_CPU, LEFT_OUT, MEDIAN_CPU, named
from suites.speed.problems import Problem
from suites.speed.races import Absent, Names
from suites.speed.rows import Row
from suites.speed.suite import NAME, SUITE
from tests.suites.speed.test_outcomes import ROW, entry

TASKS = SUITE.tasks(Scope())


class Race:
    """A race that counts; of it two contenders, one of which is not there."""

    def __init__(self, broken: bool = False) -> None:
        self.broken = broken
        self.asked: list[tuple[int, Names]] = []

    def __call__(self, problem: Problem, absent: Absent, names: Names) -> Sequence[Row]:
        self.asked.append((problem.windows, names))
        if self.broken:
            raise ValueError("a solver\nfell over")
        absent(entry("osqp", "one pass"), "osqp cannot be imported")
        return [ROW]


@pytest.fixture
def stubbed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    def put(race: Race) -> None:
        entries: tuple[Entry[Any], ...] = (entry("mhe-rti", "one pass"), entry("osqp", "one pass"))
        case = SpeedCase(CASES["pen15_20"].problem, entries, race)
        monkeypatch.setattr(suite_module, "CASES", MappingProxyType({"stub": case}))

    suite_module._raced.cache_clear()
    yield put
    suite_module._raced.cache_clear()


def run(name: str, scope: Scope, case: str = "stub") -> Any:
    return SUITE.run(Task(NAME, case, "accel+gyro", name, 0), scope)


def test_a_case_is_raced_once_for_all_its_contenders(stubbed: Any) -> None:
    race = Race()
    stubbed(race)
    assert run("mhe-rti", Scope(3)).quantities
    assert (run("osqp", Scope(3)).status, run("osqp", Scope(3)).quantities) == (LEFT_OUT, ())
    assert race.asked == [(3, ["mhe-rti", "osqp"])]
    run("mhe-rti", Scope(500, estimators=("mhe-rti", "ekf")))
    assert race.asked[1:] == [(200, ["mhe-rti"])]  # no more windows than the problem has


def test_a_race_that_breaks_off_is_not_run_again_for_the_others(stubbed: Any) -> None:
    race = Race(broken=True)
    stubbed(race)
    for name in ("mhe-rti", "osqp"):
        found = run(name, Scope(2))
        assert (found.status, found.reason) == (FAILED, "ValueError: a solver fell over")
    assert len(race.asked) == 1


def test_who_does_not_race_is_named(stubbed: Any) -> None:
    with pytest.raises(InputError, match="case nowhere is unknown"):
        run("mhe-rti", Scope(1), case="nowhere")
    stubbed(Race())
    with pytest.raises(InputError, match="estimator nobody is unknown"):
        run("nobody", Scope(1))


def test_another_number_of_windows_is_another_race() -> None:
    few, more, all_of_them = (SUITE.made_of(Scope(seeds)) for seeds in (2, 200, 500))
    assert few != more == all_of_them


def test_another_acados_is_another_race(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PEN_MHE_ACADOS", raising=False)
    without = SUITE.made_of(Scope())
    monkeypatch.setenv("PEN_MHE_ACADOS", "/somewhere")
    assert SUITE.made_of(Scope()) != without


def test_every_contender_of_every_case_is_a_task() -> None:
    assert len(set(TASKS)) == len(TASKS) == sum(len(case.names) for case in CASES.values())
    assert {task.seed for task in SUITE.tasks(Scope(7))} == {0}
    assert not any("," in task.case or "," in task.estimator for task in TASKS)  # as options
    assert CASES["pen15_20"].with_windows(3).problem == replace(
        CASES["pen15_20"].problem, windows=3
    )


def quantities(case: SpeedCase, name: str) -> set[str]:
    """Return the times that a contender has in a case."""
    own = [each for each in case.entries if each.name == name]
    modes = [each.mode for each in own]
    return {
        named(mode if modes.count(mode) == 1 else f"{mode}, N = {each.horizon}", figure)
        for each, mode in zip(own, modes, strict=True)
        for figure in (LEAST_CPU, MEDIAN_CPU)
    }


def chosen(claim: Claim, of: Any) -> list[tuple[str, str, str]]:
    """Return case, contender and quantity of the rows that a claim chooses."""

    def fits(column: str, value: str) -> bool:
        wanted = of[column] if isinstance(of[column], tuple) else (of[column],)
        return any(fnmatchcase(value, str(each)) for each in wanted)

    return [
        (task.case, task.estimator, quantity)
        for task in TASKS
        if fits("case", task.case) and fits("estimator", task.estimator)
        for quantity in quantities(CASES[task.case], task.estimator)
        if fits("quantity", quantity)
    ]


@pytest.mark.parametrize("claim", load_claims(SUITE.claims), ids=lambda claim: claim.id)
def test_every_claim_finds_its_rows(claim: Claim) -> None:
    """By name, so that no claim goes without a figure for a slip of the pen."""
    asked = claim.of["estimator"] if "estimator" in claim.every else ("one",)
    of = chosen(claim, claim.of)
    assert len(of) == len(asked)  # type: ignore[arg-type]
    if claim.against is None:
        return
    against = chosen(claim, {**claim.of, **claim.against})
    assert len(against) == (len(of) if "estimator" not in claim.against else 1)
    # Compiled calls against compiled calls, Python's against Python's.
    modes = [quantity.rpartition(": ")[0] for _, _, quantity in (*of, *against)]
    if not set(modes) & {BATCH, STEP}:
        assert len({"call" in mode for mode in modes}) == 1
