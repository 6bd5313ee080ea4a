"""A mapping that cannot be changed, and is the same in another process."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import pytest

from models.frozen_mapping import FrozenMapping

GIVEN = {"a": 1, "b": 2}
CHANGES: dict[str, Callable[[Any], object]] = {
    "set": lambda m: m.__setitem__("c", 3),
    "delete": lambda m: m.__delitem__("a"),
    "or": lambda m: m.__ior__({"c": 3}),
    "clear": lambda m: m.clear(),
    "pop": lambda m: m.pop("a"),
    "popitem": lambda m: m.popitem(),
    "setdefault": lambda m: m.setdefault("c", 3),
    "update": lambda m: m.update(c=3),
}


@pytest.mark.parametrize("change", CHANGES)
def test_nothing_changes_it(change: str) -> None:
    mapping = FrozenMapping(GIVEN)
    with pytest.raises(TypeError, match="a FrozenMapping cannot be changed, expected a new one"):
        CHANGES[change](mapping)
    assert mapping == GIVEN


def test_it_is_a_copy_of_what_it_was_made_of() -> None:
    given = dict(GIVEN)
    mapping = FrozenMapping(given)
    given["c"] = 3
    assert dict(mapping) == GIVEN
    assert repr(mapping) == "FrozenMapping({'a': 1, 'b': 2})"


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))]
)
def test_a_copy_is_frozen_too(again: Callable[[Any], Any]) -> None:
    found = again(FrozenMapping(GIVEN))
    assert type(found) is FrozenMapping
    assert found == GIVEN
