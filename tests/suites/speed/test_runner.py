"""The race itself, with contenders that only say what is done to them."""

from __future__ import annotations

import gc
import time

import numpy as np
import pytest

from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from suites.speed.contender import ContenderAbsentError, Entry, RaceOutcome, peer
from suites.speed.runner import MOST_REPEATS, TURN_S, built, race

PREPARING = 10
"""How many times longer preparing takes than solving."""


class Recorder:
    """Writes down its calls; counts a time of its own where it has one."""

    version = "0"

    def __init__(self, name: str, calls: list[str], time_s: float | None, nap_s: float) -> None:
        self.name, self.calls, self.time_s, self.nap_s = name, calls, time_s, nap_s

    def prepare(self, item: int) -> None:
        self.item = item
        time.sleep(PREPARING * self.nap_s)  # must not count

    def solve(self) -> float | None:
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
    name: str, calls: list[str], time_s: float | None = None, nap_s: float = 0.0, samples: int = 1
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
    (racer,) = built([entry("a", calls, time_s=1e-6, samples=4)], model, 0, print)
    race([racer], [7], warm_up=0)
    assert calls == ["a7"] * MOST_REPEATS
    assert racer.times_s == [0.25e-6]


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

    absent: dict[str, str] = {}
    entries = [Entry("nobody", "converged", build), entry("a", [])]
    racers = built(entries, model, 0, absent.setdefault)
    assert [racer.entry.name for racer in racers] == ["a"]
    assert list(absent) == ["nobody (converged)"]
    assert absent["nobody (converged)"].startswith("nobody cannot be imported (No module named")


def test_a_race_of_nobody_is_over(model: StateSpaceModel) -> None:
    race([], [1, 2], warm_up=0)


def test_an_absent_peer_is_an_error_with_a_sentence() -> None:
    with pytest.raises(ContenderAbsentError, match="x cannot be imported"):
        peer("no_such_module_anywhere", "x")
