"""What is wrong with strangers' recordings is named, with the right remedy, and nothing else is.

Criteria, set before the seeds here were looked at: of 50 recordings of each kind at least 95 % are
named rightly, by the first finding and with a remedy that mends it; of 50 without fault none has
any finding.
"""

from __future__ import annotations

import pytest

from recordings.checks.run import findings_of
from tests.recordings.rods import KINDS, is_named, turned_rod, wrong_rod

SEEDS = range(4000, 4050)
NAMED = 0.95
QUICK = 3


def named(name: str, seeds: range) -> float:
    kind, right = KINDS[name], 0
    for seed in seeds:
        rod, pen = wrong_rod(kind, seed)
        right += is_named(kind, rod, findings_of(rod.recording(), pen))
    return right / len(seeds)


def findings_of_right_ones(seeds: range) -> dict[int, list[str]]:
    rods = {seed: turned_rod(seed) for seed in seeds}
    found = {seed: findings_of(rod.recording(), rod.pen()) for seed, rod in rods.items()}
    return {seed: [one.sentence() for one in each] for seed, each in found.items() if each}


@pytest.mark.parametrize("name", KINDS)
def test_it_is_named(name: str) -> None:
    assert named(name, SEEDS[:QUICK]) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_it_is_named_of_fifty(name: str) -> None:
    assert named(name, SEEDS) >= NAMED


def test_right_ones_have_no_finding() -> None:
    assert findings_of_right_ones(SEEDS[:QUICK]) == {}


@pytest.mark.slow
def test_fifty_right_ones_have_no_finding() -> None:
    assert findings_of_right_ones(SEEDS) == {}
