"""A few of a test's cases in which nothing is missing: what quick tests take of a full product."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Sequence
from itertools import combinations

import pytest


def cover(cases: Sequence[tuple[Hashable, ...]]) -> list[int]:
    """Return the places of cases that together have every value, chosen greedily, in order.

    Of three or more parameters they have every pair of values that some case has.
    """
    met = [_met(case) for case in cases]
    missing = set[Hashable]().union(*met)
    chosen: list[int] = []
    while missing:
        best = max(range(len(cases)), key=lambda place: len(met[place] & missing))
        chosen.append(best)
        missing -= met[best]
    return sorted(chosen)


def _met(case: tuple[Hashable, ...]) -> set[Hashable]:
    """Return what a case has that must not be missing: each with where it stands."""
    together = 2 if len(case) > 2 else 1
    return set(combinations(enumerate(case), min(together, len(case))))


def left_out(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """Return the cases that the cover of their test, where it is marked ``cover``, does without."""
    by_test: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("cover"):
            by_test[item.nodeid.partition("[")[0]].append(item)
    out = []
    for cases in by_test.values():
        kept = set(cover([_values(case) for case in cases]))
        out += [case for place, case in enumerate(cases) if place not in kept]
    return out


def _values(item: pytest.Item) -> tuple[Hashable, ...]:
    """Return what stands for a case's value of each parameter: names given together are one."""
    params = item.callspec.params  # type: ignore[attr-defined]
    told = [mark.args[0] for mark in item.iter_markers("parametrize")]
    groups = [tuple(x.strip() for x in t.split(",")) if isinstance(t, str) else t for t in told]
    named = {name for group in groups for name in group}
    groups += [(name,) for name in params if name not in named]
    return tuple(tuple(id(params[name]) for name in group) for group in groups)
