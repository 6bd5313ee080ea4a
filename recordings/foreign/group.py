"""Columns of a table that are one sensor's reading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.shown_text import short
from recordings.foreign.header_units import Unit, split_header
from recordings.foreign.source_table import SourceTable
from recordings.formats.columns import Column, numbers, side_by_side

POSE, TIP = "pose_camera", "tip_position"
POSE_AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")
"""Of a position and a quaternion, which becomes a rotation vector."""
TURNS = ("rx", "ry", "rz")
"""Axes of a rotation vector."""

MINUS = "-"
"""In front of a column that somebody names: it reads the other way round."""

Rows = slice | NDArray[np.int64]
ALL: Rows = slice(None)


@dataclass(frozen=True, eq=False)
class Group:
    """Columns of a table that are one sensor's reading.

    Parameters
    ----------
    kind : of `recordings.foreign.column_names.KIND_WORDS`, or of a sensor of the pen
    label : which of several
    table : where they stand
    headers : axis → column
    unit : as the headers write it; None where they do not
    sensor : of the pen, where the headers or somebody names it
    added : columns that are added to the first, axis by axis: gravity to what is without it
    own : axis → column as a recording of the pen calls it, where the file does so too
    known : what such columns mean
    signs : axis → -1 where its column reads the other way round
    """

    kind: str
    label: str
    table: SourceTable
    headers: Mapping[str, str]
    unit: Unit | None
    sensor: str | None = None
    added: Mapping[str, str] | None = None
    own: Mapping[str, str] = field(default_factory=dict)
    known: Mapping[str, Column] = field(default_factory=dict)
    signs: Mapping[str, float] = field(default_factory=dict)

    def values(
        self, axes: Sequence[str], rows: Rows = ALL, *, factors: Array | None = None
    ) -> Array:
        """Return the readings (n, k), NaN where there is none: as they stand, or times factors."""
        where = f"recording {self.table.name}"
        whole = isinstance(rows, slice) and rows == ALL
        some = None if whole else rows
        if not axes:
            return np.empty((0, 0))
        columns = [self._column(self.headers[axis], some, where) for axis in axes]
        if self.added is not None:
            more = [self._column(self.added[axis], some, where) for axis in axes]
            columns = [one + other for one, other in zip(columns, more, strict=True)]
        signs = np.array([self.signs.get(axis, 1.0) for axis in axes])
        return side_by_side(columns, signs if factors is None else signs * factors)

    def _column(self, header: str, rows: Rows | None, where: str) -> Array:
        cells = self.table.frame[header]
        return numbers(cells if rows is None else cells.iloc[rows], where)

    def factors(self, axes: Sequence[str], factor: float) -> Array:
        """Return the factors to SI (k,): those of the columns' own names, else one for all.

        A pose's angles have that of their headers, else are in rad.
        """
        if self.kind == POSE and not self.own:
            return np.array(
                [_angle_factor(self.headers[a]) if a in TURNS else factor for a in axes]
            )
        if not self.own:
            return np.full(len(axes), factor)
        return np.array([self.known[self.own[axis]].factor for axis in axes])

    @property
    def has_quaternion(self) -> bool:
        """Whether it is a pose whose attitude is a quaternion."""
        return self.kind == POSE and "qw" in self.headers

    def used(self) -> tuple[str, ...]:
        """Return the names of its columns."""
        return (*self.headers.values(), *(self.added or {}).values())

    def axis_columns(self) -> tuple[str, ...]:
        """Return the names of its columns with their signs, as ``--columns`` takes them."""
        signs = {axis: "-" if self.signs.get(axis, 1.0) < 0 else "" for axis in self.headers}
        return tuple(f"{signs[axis]}{header}" for axis, header in self.headers.items())

    def columns(self) -> str:
        """Return the names of its columns in a sentence."""
        names = ", ".join(map(short, self.axis_columns()))
        return names if self.added is None else f"{names} plus {', '.join(self.added.values())}"


def _angle_factor(header: str) -> float:
    unit = split_header(header)[1]
    return 1.0 if unit is None or unit.si != "rad" else unit.factor
