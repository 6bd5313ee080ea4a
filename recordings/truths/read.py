"""A truth of a pen from a file: motion capture, a tablet, angles; any table that is read at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from estimation.recording import Recording
from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.pen_file import AnyPen, as_pen
from models.shown_text import one_line, short
from recordings.asked import Asked
from recordings.foreign.clocks import stamps_asked
from recordings.foreign.repairs import mended_times
from recordings.foreign.source_table import SourceTable
from recordings.foreign.stamps import LARGE_S
from recordings.formats.columns import TIME, loose_numbers
from recordings.formats.table import format_names
from recordings.read import format_row
from recordings.truths.asked import meant_columns, named_columns, with_units
from recordings.truths.columns import (
    ANGLE,
    DOWN,
    PLACE,
    TURN,
    TruthColumn,
    as_motive,
    complete_groups,
    truth_column,
)
from recordings.truths.of_recording import track_of_recording
from recordings.truths.track import ANGLES, TruthTrack

LARGEST_M = 3.0
"""A pen that moves further, in a unit that nobody wrote, moves in millimetres."""
UNIT_NORM = 0.1
"""How far the norm of a quaternion may be from one."""
EXPECTED = (
    "positions (x, y or x, y, z), quaternions (qx, qy, qz, qw), or angles of the pen "
    "(azimuth_deg, elevation_deg, spin_deg)"
)


def read_truth(
    path: str | Path, pen: AnyPen, *, origin_s: float = 0.0, asked: Asked | None = None
) -> TruthTrack:
    """Read what somebody else measured of a pen's motion.

    Of a recording that this project reads it takes the true states, or what a camera of the pen
    saw; see `recordings.truths.of_recording`.

    Parameters
    ----------
    path : of one of `recordings.formats.table.FORMATS`
    pen : whose cameras may be in it
    origin_s : of the estimate's times, s: what was taken off a clock that counts from an epoch
    asked : which columns are which of `recordings.truths.asked.QUANTITIES`, and their units

    Raises
    ------
    InputError
        If it does not exist, cannot be read, or holds nothing of a pen's motion, no times, or not
        what is asked for.
    """
    path, asked = Path(path), Asked() if asked is None else asked
    with reading(f"truth {path}", format_names()):
        row = format_row(path, "truth")
        if row.tables is None:
            return track_of_recording(row.read_own(path, as_pen(pen), asked).recording, pen)
        tables = row.tables(path, f"truth {path}", header=asked.header)
        named = named_columns(tables, asked, f"truth {path}")
        meant = [
            (one, names, _columns(one, names)) for one, names in zip(tables, named, strict=True)
        ]
        found = [one for one in meant if one[2]]
        if found:
            table, names, columns = max(found, key=lambda one: len(one[2]))
            columns = with_units(columns, asked.units, f"truth {path}")
            return _track(table, columns, str(path), origin_s, asked, names.get(TIME))
        recording = None if asked.is_of_others else _as_recording(path, pen)
        if recording is not None:
            return track_of_recording(recording, pen)
        headers = [str(header) for table in tables for header in table.frame.columns]
        raise InputError(
            f"truth {path}: nothing of a pen's motion among {', '.join(map(short, headers[:12]))}, "
            f"expected {EXPECTED}"
        )


def _as_recording(path: Path, pen: AnyPen) -> Recording | None:
    from recordings.read import read_written

    try:
        return read_written(path, pen).recording
    except InputError:
        return None


@dataclass(frozen=True, eq=False)
class _Cells:
    """Columns of a table's rows, in SI, and what was assumed of their units."""

    frame: pd.DataFrame
    columns: dict[str, TruthColumn]

    def values(self, headers: list[str]) -> Array:
        found = np.column_stack(
            [self.columns[header].sign * loose_numbers(self.frame[header]) for header in headers]
        )
        found[~np.isfinite(found)] = np.nan
        return found

    def given(self, headers: list[str]) -> float | None:
        """Return the factor that all headers say."""
        factors = {self.columns[header].factor for header in headers}
        return factors.pop() if len(factors) == 1 else None


def _columns(table: SourceTable, named: Mapping[str, Sequence[str]]) -> dict[str, TruthColumn]:
    headers = [str(header) for header in table.frame.columns]
    found = as_motive(headers)
    if not found:
        found = {h: one for h in headers if (one := truth_column(h, table.name)) is not None}
    found = meant_columns(named, found)
    return found if set(complete_groups(found)) - {DOWN} else {}


def _track(
    table: SourceTable,
    columns: dict[str, TruthColumn],
    name: str,
    origin_s: float,
    asked: Asked,
    time: Sequence[str] | None,
) -> TruthTrack:
    where = f"truth {name}"
    groups = complete_groups(columns)
    stamps = stamps_asked(table, asked, where, named=time, units=asked.units, kind=None)
    first_s = stamps.first_s()
    start_s = (origin_s or float(np.floor(first_s))) if first_s > LARGE_S else 0.0
    cells = _Cells(table.frame, columns)
    mended = mended_times(
        stamps.seconds(start_s), lambda: cells.values([h for h in columns if h in table.frame])
    )
    cells = _Cells(table.frame.iloc[mended.rows], columns)
    said = [*table.said, *(f"repaired: {one}" for one in (*stamps.repairs, *mended.repairs))]
    said += mended.said
    if stamps.is_to_be_said:
        said.append(f"times from {stamps.header}, in {stamps.unit.name}")
    if start_s > 0:
        said.append(f"times count from {start_s:.0f} s of its clock")
    place, turn, angle = (_first(groups, kind, said) for kind in (PLACE, TURN, ANGLE))
    if turn is not None:
        angle = None  # a quaternion says more
    own = [columns[h].is_own for group in (place, turn) for h in (group or {}).values()]
    return TruthTrack(
        name,
        mended.time_s,
        position=None if place is None else _places(cells, place, groups, said),
        attitude=None if turn is None else _turns(cells, turn, where),
        angles=None if angle is None else _angles(cells, angle, said),
        is_of_pen=turn is None or all(own),
        is_level=all(own) or (turn is None and (angle is not None or 2 not in (place or {}))),
        said=tuple(one_line(f"{name}: {one}") for one in said),
    )


def _first(
    groups: dict[str, list[dict[int, str]]], kind: str, said: list[str]
) -> dict[int, str] | None:
    several = groups.get(kind, [])
    said += [f"{', '.join(map(short, other.values()))} not used" for other in several[1:]]
    return several[0] if several else None


def _places(
    cells: _Cells, group: dict[int, str], groups: dict[str, list[dict[int, str]]], said: list[str]
) -> Array:
    headers = [group[axis] for axis in range(3) if axis in group]
    values, factor = cells.values(headers), cells.given(headers)
    if DOWN in groups:
        (header,) = list(groups[DOWN][0].values())[:1]
        down = cells.values([header])[:, 0] > 0
        if down.any() and not down.all():
            values[~down] = np.nan
            said.append(f"{down.mean():.0%} of its rows count, where {short(header)} says pen down")
    if factor is None:
        known = values[np.isfinite(values).all(axis=1)]
        extent = float(np.ptp(known, axis=0).max()) if len(known) else 0.0
        factor, unit = (1.0, "m") if extent <= LARGEST_M else (1e-3, "mm")
        said.append(f"{', '.join(map(short, headers))} taken in {unit}, by how far it moves")
    return np.asarray(values * factor)


def _turns(cells: _Cells, group: dict[int, str], where: str) -> Array:
    values = cells.values([group[axis] for axis in range(4)])
    norms = np.linalg.norm(values, axis=1)
    bad = ~(np.abs(norms - 1) < UNIT_NORM)
    told = np.isfinite(norms) & (norms > 0)
    if (bad & told).sum() > 0.5 * max(told.sum(), 1):
        raise InputError(
            f"{where}: the norms of {', '.join(map(short, group.values()))} are "
            f"{np.nanmedian(norms):.3g}, expected quaternions"
        )
    values[bad] = np.nan
    return np.asarray(values / norms[:, None])


def _angles(cells: _Cells, group: dict[int, str], said: list[str]) -> Array:
    found = np.full((len(cells.frame), len(ANGLES)), np.nan)
    values = cells.values(list(group.values()))
    unwritten = [h for h in group.values() if cells.columns[h].factor is None]
    largest = np.nanmax(np.abs(cells.values(unwritten)), initial=0.0) if unwritten else 0.0
    assumed, unit = (np.pi / 180, "deg") if largest > 2 * np.pi + 0.1 else (1.0, "rad")
    if unwritten:
        said.append(f"{', '.join(map(short, unwritten))} taken in {unit}")
    for k, (axis, header) in enumerate(group.items()):
        factor = cells.columns[header].factor
        found[:, axis] = values[:, k] * (assumed if factor is None else factor)
    return found
