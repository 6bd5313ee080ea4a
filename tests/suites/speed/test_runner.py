"""The race itself, with contenders that only say what is done to them."""

from __future__ import annotations

import gc
import time
from dataclasses import replace

import numpy as np
import pytest

from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from suites.speed import runner
from suites.speed.clock import (
    OWN_CPU_CLOCK,
    OWN_WALL_CLOCK,
    THREAD_CLOCK,
    Counted,
    Reading,
    clock_floor_ns,
    read,
)
from suites.speed.contender import ContenderAbsentError, Entry, RaceOutcome, peer
from suites.speed.runner import MOST_REPEATS, TURN_S, built, race

PREPARING = 10
"""How many times longer preparing takes than solving."""


class Recorder:
    """Writes down its calls; counts a time of its own where it has one; naps."""

    version = "0"

    def __init__(self, name: str, calls: list[str], time_s: Counted | None, nap_s: float) -> None:
        self.name, self.calls, self.time_s, self.nap_s = name, calls, time_s, nap_s

    def prepare(self, item: int) -> None:
        self.item = item
        time.sleep(PREPARING * self.nap_s)  # must not count

    def solve(self) -> Counted | None:
        assert not gc.isenabled()
        self.calls.append(f"{self.name}{self.item}")
        time.sleep(self.nap_s)
        return self.time_s

    def outcome(self) -> RaceOutcome:
        return RaceOutcome(1.0, np.array([float(self.item)]))


@pytest.fixture(scope="module")
def model() -> StateSpaceModel:
    return turntable_model(paper_turntable())


def entry(
    name: str, calls: list[str], time_s: Counted | None = None, nap_s: float = 0.0, samples: int = 1
) -> Entry[int]:
    return Entry(name, "mode", lambda m, i: Recorder(name, calls, time_s, nap_s), samples)


def test_who_begins_moves_on_by_one(model: StateSpaceModel) -> None:
    calls: list[str] = []
    nap_s = 1.1 * TURN_S
    racers = built([entry(name, calls, nap_s=nap_s) for name in "abc"], model, 0, print)
    share = race(racers, [0, 1, 2, 3], warm_up=1)
    assert 0 < share < 0.5  # asleep most of the time
    assert calls == ["a0", "b0", "c0", "b1", "c1", "a1", "c2", "a2", "b2", "a3", "b3", "c3"]
    for racer in racers:
        assert [outcome.newest[0] for outcome in racer.outcomes] == [1, 2, 3]
        # One nap per solve, none of prepare; a busy machine may make a single nap longer.
        assert all(time_s >= nap_s for time_s in racer.times_s)
        assert min(racer.times_s) < PREPARING * nap_s
    assert gc.isenabled()


def test_a_quick_contender_repeats_its_turn(model: StateSpaceModel) -> None:
    calls: list[str] = []
    (racer,) = built([entry("a", calls, Counted(1e-6), samples=4)], model, 0, print)
    race([racer], [7], warm_up=0)
    assert calls == ["a7"] * MOST_REPEATS
    assert racer.times_s == [0.25e-6]
    (turn,) = racer.turns
    assert set(turn.readings) == {Reading(0.25e-6, 0.25e-6, OWN_WALL_CLOCK)}
    assert len(turn.readings) == MOST_REPEATS


def test_what_starts_cold_finds_the_caches_empty_at_every_call(
    model: StateSpaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    monkeypatch.setattr(runner, "forget_caches", lambda: calls.append("forgotten"))
    cold, hot = (entry(name, calls, Counted(1e-3)) for name in ("cold", "hot"))
    race(built([replace(cold, is_cold=True), hot], model, 0, print), [7], warm_up=0)
    assert calls[:4] == ["forgotten", "cold7", "forgotten", "cold7"]
    assert calls[-2:] == ["hot7", "hot7"]


def test_who_counts_cpu_time_itself_is_believed(model: StateSpaceModel) -> None:
    (racer,) = built([entry("a", [], Counted(3e-3, 2e-3))], model, 0, print)
    race([racer], [7], warm_up=0)
    assert racer.turns[0].readings == (Reading(3e-3, 2e-3, OWN_CPU_CLOCK),)


def test_sleep_is_wall_time_and_no_cpu_time(model: StateSpaceModel) -> None:
    nap_s = 5 * TURN_S
    (racer,) = built([entry("a", [], nap_s=nap_s)], model, 0, print)
    race([racer], [7], warm_up=0)
    (reading,) = racer.turns[0].readings
    assert reading.clock == THREAD_CLOCK
    assert reading.wall_s >= nap_s
    assert 0 < reading.cpu_s < 0.2 * nap_s


def test_work_is_cpu_time_and_the_clock_is_none() -> None:
    def work() -> None:
        end_ns = time.thread_time_ns() + 3_000_000
        while time.thread_time_ns() < end_ns:
            pass

    floor_ns = clock_floor_ns()
    worked = read(work, floor_ns)
    assert worked.cpu_s >= 3e-3 - 1e-9 * floor_ns
    nothing = [read(lambda: None, ns).cpu_s for ns in (floor_ns, 0) for _ in range(100)]
    assert min(nothing[:100]) < min(nothing[100:])


def test_garbage_collection_comes_back_after_a_failure(model: StateSpaceModel) -> None:
    calls: list[str] = []
    (racer,) = built([entry("a", calls)], model, 0, print)
    racer.contender.prepare = None  # type: ignore[assignment, method-assign]
    with pytest.raises(TypeError):
        race([racer], [7], warm_up=0)
    assert gc.isenabled()


def test_what_cannot_be_built_is_left_out_by_name(model: StateSpaceModel) -> None:
    def build(model: StateSpaceModel, item: int) -> Recorder:
        peer("no_such_module_anywhere", "nobody")
        raise AssertionError

    absent: dict[Entry[int], str] = {}
    entries = [Entry("nobody", "converged", build), entry("a", [])]
    racers = built(entries, model, 0, absent.setdefault)
    assert [racer.entry.name for racer in racers] == ["a"]
    ((gone, why),) = absent.items()
    assert gone.label == "nobody (converged)"
    assert why.startswith("nobody cannot be imported (No module named")


def test_a_race_of_nobody_is_over(model: StateSpaceModel) -> None:
    race([], [1, 2], warm_up=0)


def test_an_absent_peer_is_an_error_with_a_sentence() -> None:
    with pytest.raises(ContenderAbsentError, match="x cannot be imported"):
        peer("no_such_module_anywhere", "x")
