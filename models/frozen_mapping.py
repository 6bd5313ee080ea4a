"""A mapping that nobody changes, that pickles and that deep-copies.

A ``MappingProxyType`` does neither: a value that holds one cannot go to another process.
"""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

KeyT = TypeVar("KeyT")
ValueT = TypeVar("ValueT")


class FrozenMapping(dict[KeyT, ValueT]):
    """A dict, as writers of JSON and pydantic want one, without what changes it."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} cannot be changed, expected a new one")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type, tuple[dict[KeyT, ValueT]]]:
        return type(self), (dict(self),)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({dict(self)!r})"
