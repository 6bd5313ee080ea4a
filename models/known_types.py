"""Objects from files of ours that somebody may have altered: fields are what they should be."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
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
