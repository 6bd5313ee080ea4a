"""What a step tells, as a C structure: derived from the layout of the loops' results."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from estimation.layout import Layout

WORDS: Mapping[str, str] = MappingProxyType(
    {
        "time_s": "s, of the newest state",
        "status": "bits STATUS_...; 0: solved without a remark",
        "iterations": "passes; 1 for a filter, 0 where the measurement was out of reach",
        "reused": "stages whose factors were kept",
        "mean": "estimate of the states",
        "covariance": "of the estimate, row by row, in products of the states' units",
        "derived": "what people read, derived from the states: DERIVED_...",
        "derived_std": "its standard deviations",
        "innovation": "reading minus prediction, NaN where none; units of the rows above",
        "innovation_covariance": "of the innovation",
        "cost": "of the window; NaN where none is counted",
        "kkt": "distance from the optimality conditions, standard deviations; NaN for a filter",
        "step_time_s": "s; 0 without a clock",
        "lagged_time": "s, of the states as many samples before the newest; NaN where none",
        "lagged_mean": "estimates of these states, given all readings up to the newest",
        "lagged_covariance": "of these, lag behind lag; NaN where there was no time for it",
        "lagged_derived": "what people read, derived from these states, lag behind lag",
        "lagged_derived_std": "its standard deviations",
    }
)
"""Block of `estimation.result.result_layout` → what it says, for the header."""

NUMBERS: Mapping[str, tuple[str, type]] = MappingProxyType(
    {
        "time_s": ("double", ctypes.c_double),
        "status": ("unsigned", ctypes.c_uint),
        "iterations": ("int", ctypes.c_int),
        "reused": ("int", ctypes.c_int),
        "lagged_time": ("double", ctypes.c_double),
    }
)
"""Blocks that have a type of their own; the loop tells them as real numbers."""

FLAGGED = "flagged"
"""Member with what a watch says of each sensor."""

TOLD = "told"
"""Member with those as the loop tells them."""


@dataclass(frozen=True)
class Field:
    """A member of the structure: C type, None for a real number, and shape, () for one."""

    name: str
    c_type: str | None
    shape: tuple[int, ...]
    words: str


def estimate_fields(result: Layout) -> list[Field]:
    """Return the structure's members, those of a type of their own first; none of no numbers."""
    numbers = [
        Field(name, c_type, result.shapes[name], WORDS[name])
        for name, (c_type, _) in NUMBERS.items()
        if 0 not in result.shapes[name]
    ]
    blocks = [
        Field(name, None, shape, WORDS.get(name, name))
        for name, shape in result.shapes.items()
        if name not in NUMBERS and 0 not in shape
    ]
    told = Field(TOLD, None, (sum(math.prod(field.shape) for field in numbers),), "private")
    return [*numbers, *blocks, told]


def flag_field(n_sensors: int) -> Field:
    """Return the member that a watched estimate has behind all others."""
    return Field(FLAGGED, "unsigned char", (n_sensors,), "bits FLAG_... of each sensor, SENSOR_...")


def offsets(result: Layout) -> dict[str, int]:
    """Return where each block stands behind the first real member, for the loop's structure.

    A block of no numbers has no member, and stands where it does no harm.
    """
    places, at = {}, 0
    for member in estimate_fields(result):
        if member.c_type is None:
            places[member.name] = at
            at += math.prod(member.shape)
    told = places.pop(TOLD)
    for member in estimate_fields(result):
        if member.c_type is not None:
            places[member.name] = told
            told += math.prod(member.shape)
    return {**{block: places.get(block, 0) for block in result.shapes}, "size": at}


def estimate_structure(fields: Sequence[Field], real: Any) -> type[ctypes.Structure]:
    """Return the structure for Python; `real` is c_double or c_float."""
    types = {name: kind for name, (_, kind) in NUMBERS.items()} | {FLAGGED: ctypes.c_ubyte}
    kinds = [(field, types.get(field.name, real)) for field in fields]
    members = [(f.name, kind * math.prod(f.shape) if f.shape else kind) for f, kind in kinds]
    return type("Estimate", (ctypes.Structure,), {"_fields_": members})
