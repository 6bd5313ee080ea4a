"""What a configuration says, as a key: two that say the same, to the last digit, are equal.

A configuration that holds tables has no hash, and its ``==`` takes tables of another order and
-0 for 0 as the same.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from types import NoneType
from typing import Any, Generic, TypeVar

import numpy as np
from pydantic import BaseModel

ConfigT = TypeVar("ConfigT", bound=BaseModel)

PLAIN = (str, int, float, bool, NoneType)
"""Types whose ``repr`` is all that a value of them is."""


class ByContent(Generic[ConfigT]):
    """A configuration for a cache: found again by what it says, now and not later.

    One that holds what has no content of its own (an array, an object of another class) is found
    by nobody: such a thing may change and stay itself.
    """

    def __init__(self, config: ConfigT) -> None:
        self.config = config
        try:
            self._content = content_of(config)
        except TypeError:
            self._content = object()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ByContent) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)


def content_of(value: Any) -> Hashable:
    """Return types, keys in their order and digits of nested configurations.

    Raises
    ------
    TypeError
        If there is a value in it of which nobody knows what it says.
    """
    if type(value) in PLAIN or isinstance(value, np.generic):
        return type(value), repr(value)
    if isinstance(value, Mapping):
        return Mapping, *((content_of(key), content_of(item)) for key, item in value.items())
    if isinstance(value, tuple | list):
        return tuple, *(content_of(item) for item in value)
    if isinstance(value, BaseModel):
        own = vars(value), value.__pydantic_extra__, value.__pydantic_private__
        return type(value), *(content_of(part) for part in own)
    raise TypeError(f"a {type(value).__name__} has no content")
