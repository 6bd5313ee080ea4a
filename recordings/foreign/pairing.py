"""Which of several groups of a kind is which sensor of the pen.

By words that both have (``accel_lower``: ``lower acc x``); by the chip that another sensor with
such a word was found on (``gyro_lower`` goes where ``accel_lower`` is); else by the numbers of the
chips, or in the file's order.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

from recordings.foreign.column_names import kind_of_words
from recordings.foreign.group import Group
from recordings.foreign.header_units import words_of

_Fits = Callable[[str, Group], bool]


def paired(
    free: Sequence[str], candidates: Sequence[Group], taken: Mapping[str, Group]
) -> dict[str, Group]:
    """Return sensor → group.

    Parameters
    ----------
    free : names of the pen's sensors of a kind that nothing is found for yet
    candidates : groups of that kind
    taken : sensor → group of other kinds, and of this one by name
    """
    if len(candidates) == len(free):
        for fits in (_by_words, _beside(taken)):
            found = {n: g for n in free for g in candidates if fits(n, g)}
            if len(found) == len(free) == len({id(g) for g in found.values()}):
                return found
        return dict(zip(free, _in_order(candidates), strict=True))
    found = {}
    for name in free:
        fit = [g for g in candidates if _by_words(name, g) and g not in found.values()]
        if fit:
            found[name] = fit[0]
    if found or (taken and any(g.kind == candidates[0].kind for g in taken.values())):
        return found
    # A gyroscope of the chip whose accelerometer was taken.
    beside = [g for g in candidates if any(same_chip(g, other) for other in taken.values())]
    return {free[0]: (beside or sorted(candidates, key=lambda g: len(g.label)))[0]}


def same_chip(a: Group, b: Group) -> bool:
    """Whether two groups stand in one table with one label."""
    return a.table is b.table and a.label == b.label


def _by_words(name: str, group: Group) -> bool:
    return bool(_own_words(name) & {*words_of(group.label), *words_of(group.table.name)})


def _beside(taken: Mapping[str, Group]) -> _Fits:
    def fits(name: str, group: Group) -> bool:
        alike = [g for other, g in taken.items() if _own_words(name) & _own_words(other)]
        return any(same_chip(group, other) for other in alike)

    return fits


def _in_order(candidates: Sequence[Group]) -> list[Group]:
    """Return groups by the numbers in their labels, where each has one of its own."""
    numbers = [tuple(map(int, re.findall(r"\d+", group.label))) for group in candidates]
    if not all(numbers) or len(set(numbers)) < len(numbers):
        return list(candidates)
    return [group for _, group in sorted(zip(numbers, candidates, strict=True), key=lambda p: p[0])]


def _own_words(name: str) -> set[str]:
    """Return the words of a sensor's name that tell it from others of its kind."""
    return {word for word in words_of(name) if kind_of_words(word) is None}
