"""Objects from files of ours that somebody may have altered: only of types that belong there."""

from __future__ import annotations

import dataclasses
import io
import pickle
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

from models.shown_text import value_text

FoundT = TypeVar("FoundT")

_KINDS: Mapping[str, Any] = {
    "str": str,
    "int": int,
    "bool": bool,
    "float": (int, float),
    "float | None": (int, float, type(None)),
    "Array": np.ndarray,
    "Array | None": (np.ndarray, type(None)),
}
"""Type of a field, as it is written there → what may stand in it."""

_ARRAYS = ("_reconstruct", "scalar", "ndarray", "dtype", "_frombuffer")
"""Functions and classes of NumPy by which an array is unpickled."""
_PLAIN = ("complex", "set", "frozenset", "bytearray", "slice", "range")


def checked_fields(found: FoundT) -> FoundT:
    """Return an object of a dataclass whose fields are what they should be.

    Arrays in it have one length, whole numbers fit into 64 bits.

    Raises
    ------
    TypeError
        If one is not; the message names it.
    """
    fields = dataclasses.fields(found)  # type: ignore[arg-type]
    lengths = set()
    for field in fields:
        entry, kind = getattr(found, field.name), _KINDS.get(str(field.type), object)
        is_large = isinstance(entry, int) and abs(entry) >= 2**63
        if not isinstance(entry, kind) or is_large:
            raise TypeError(f"{field.name} is {value_text(entry)}, expected {field.type}")
        if isinstance(entry, np.ndarray):
            lengths.add(len(entry))
    if len(lengths) > 1:
        raise TypeError(f"arrays have lengths {sorted(lengths)}, expected one")
    return found


class _OwnPickle(pickle.Unpickler):
    """Knows classes of some packages, and arrays; what else a pickle names is refused.

    A pickle may name any function, and what it names is called.
    """

    def __init__(self, data: bytes, packages: Iterable[str]) -> None:
        super().__init__(io.BytesIO(data))
        self._packages = frozenset(packages)

    def find_class(self, module: str, name: str) -> Any:
        """Return what a pickle names; raises `pickle.UnpicklingError` for what it may not."""
        package = module.split(".")[0]
        if (package == "numpy" and name in _ARRAYS) or (module == "builtins" and name in _PLAIN):
            return super().find_class(module, name)
        if package in self._packages and isinstance(
            found := super().find_class(module, name), type
        ):
            return found
        raise pickle.UnpicklingError(f"names {module}.{name}, which does not belong there")


def unpickled(data: bytes, packages: Iterable[str]) -> Any:
    """Return the object of a pickle that holds plain values, arrays and classes of packages.

    Parameters
    ----------
    packages : names of those that may be imported: ``suites``

    Raises
    ------
    Exception
        Whatever a damaged pickle makes of itself.
    """
    return _OwnPickle(data, packages).load()
