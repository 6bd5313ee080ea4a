"""What the columns of a pen's recordings are called, and in which units they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from models.config import UnitConfig

Names = Annotated[
    tuple[str, ...],
    BeforeValidator(lambda names: names.split(",") if isinstance(names, str) else names),
]


def _stripped(columns: Any) -> Any:
    if not isinstance(columns, Mapping):
        return columns
    return {
        key: ",".join(part.strip() for part in names.split(","))
        if isinstance(names, str)
        else names
        for key, names in columns.items()
    }


class RecordingColumns(UnitConfig):
    """How a logger calls what this pen's sensors read; a table without such columns is read as any.

    Parameters
    ----------
    columns : sensor, or ``time`` → its columns in order of its axes: ``["ax", "ay", "az"]``
    units : sensor, or ``time`` → unit of these: ``mg``, ``g/16384`` for counts
    """

    columns: Annotated[Mapping[str, Names], BeforeValidator(_stripped)] = Field(
        default_factory=dict
    )
    units: Mapping[str, str] = Field(default_factory=dict)
