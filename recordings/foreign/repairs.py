"""Times that increase, from stamps that repeat, go back, are missing or begin anew.

Rows stand in the order in which they were sampled: a stamp that does not advance is replaced by
one between its neighbours, as many as possible are kept. Rows that were written in another order
than sampled, which is so where sorting makes their stamps regular, are sorted instead.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.units import TIME_DIGITS
from recordings.foreign.told import counted

GAP_STEPS, LEAST_GAP_S = 5.0, 0.05
"""A step of more than so many usual ones, and of so much, is a gap."""
REGULAR = 0.2
"""Steps whose spread is at most this part of the usual one are regular."""
RESTART_S, RESTART_ROWS = 1.0, 20


@dataclass(frozen=True, eq=False)
class MendedTimes:
    """Rows that are kept, in order, and their times.

    Parameters
    ----------
    rows : (m,) indices of rows; all of them as a slice
    time_s : (m,) increasing
    repairs : sentences on what was mended
    said : sentences on what was seen and left: gaps
    """

    rows: slice | NDArray[np.int64]
    time_s: Array
    repairs: tuple[str, ...]
    said: tuple[str, ...]


def mended_times(stamps_s: Array, readings: Callable[[], Array]) -> MendedTimes:
    """Return increasing times for the rows of a table.

    Parameters
    ----------
    stamps_s : (n,) NaN where one is missing
    readings : returns those (n, k) of the rows: one that repeats stamp and readings was written
        twice
    """
    times = np.round(stamps_s, TIME_DIGITS)
    is_good = len(times) > 1 and bool(np.isfinite(times[[0, -1]]).all())
    if is_good and bool((np.diff(times) > 0).all()):  # NaN is not: there is nothing to be mended
        return MendedTimes(slice(None), times, (), _gaps(times))
    repairs: list[str] = []
    rows = np.flatnonzero(np.isfinite(stamps_s))
    if untimed := len(stamps_s) - len(rows):
        repairs.append(f"{counted(untimed, 'row')} without a time left out")
    times = times[rows]
    same = np.flatnonzero(np.diff(times) == 0)
    if len(same):
        read = readings()[rows]
        alike = (read[same] == read[same + 1]) | (np.isnan(read[same]) & np.isnan(read[same + 1]))
        twice = same[alike.all(axis=1)] + 1
        rows, times = np.delete(rows, twice), np.delete(times, twice)
        if len(twice):
            repairs.append(f"{counted(len(twice), 'row')} written twice left out")
    rows, times = _longest_session(rows, times, repairs)
    if (np.diff(times) <= 0).any():
        order = np.argsort(times, kind="stable")
        if _is_regular(times[order]):
            moved = int((np.diff(times) < 0).sum())
            rows, times = rows[order], times[order]
            places = counted(moved, "place")
            repairs.append(f"rows out of order at {places} put in the order of their times")
        else:
            equal, back = int((np.diff(times) == 0).sum()), int((np.diff(times) < 0).sum())
            times, n = _between_neighbours(times)
            found = [f"{k} {word}" for k, word in ((equal, "equal"), (back, "backward")) if k]
            repairs.append(
                f"{' and '.join(found)} stamps: {counted(n, 'time')} placed between neighbours"
            )
    is_all = len(rows) == len(stamps_s) and bool((np.diff(rows) > 0).all())
    return MendedTimes(slice(None) if is_all else rows, times, tuple(repairs), _gaps(times))


def _longest_session(
    rows: NDArray[np.int64], times: Array, repairs: list[str]
) -> tuple[NDArray[np.int64], Array]:
    """Return the longest part of a file in which the clock did not begin anew."""
    falls = np.flatnonzero(np.diff(times) < -RESTART_S) + 1
    # A stamp alone that is wrong is no new beginning.
    n = RESTART_ROWS
    starts = np.array(
        [k for k in falls if times[k : k + n].max() < np.median(times[max(k - n, 0) : k])], int
    )
    edges = [0, *starts.tolist(), len(times)]
    parts = [(a, b) for a, b in pairwise(edges) if b - a >= RESTART_ROWS]
    if len(parts) < 2 or sum(b - a for a, b in parts) < 0.9 * len(times):
        return rows, times
    a, b = max(parts, key=lambda part: part[1] - part[0])
    repairs.append(
        f"the clock begins anew at {counted(len(parts) - 1, 'place')}: "
        f"the longest part, rows {rows[a] + 1} to {rows[b - 1] + 1}, is taken"
    )
    return rows[a:b], times[a:b]


def _is_regular(times: Array) -> bool:
    steps = np.diff(times)
    usual = float(np.median(steps))
    if not (usual > 0 and steps.min() > 0 and steps.max() < GAP_STEPS * usual):
        return False
    return bool(np.quantile(abs(steps - usual), 0.9) < REGULAR * usual)


def _between_neighbours(times: Array) -> tuple[Array, int]:
    """Replace the fewest times so that they increase; return how many were."""
    kept = _increasing(times)
    n = len(times)
    step = float(np.median(np.diff(times[kept]) / np.diff(kept))) if len(kept) > 1 else 1.0
    index, known = kept.astype(float), times[kept]
    # Beyond both ends a usual step goes on.
    index = np.concatenate([[-1.0], index, [float(n)]])
    known = np.concatenate(
        [[known[0] - step * (kept[0] + 1)], known, [known[-1] + step * (n - kept[-1])]]
    )
    found = np.interp(np.arange(n), index, known)
    found[kept] = times[kept]
    found = np.round(found, TIME_DIGITS)
    if (np.diff(found) <= 0).any():  # neighbours a nanosecond apart
        found = found[0] + step * np.arange(n)
        return np.round(found, TIME_DIGITS), n
    return found, n - len(kept)


def _increasing(times: Array) -> NDArray[np.int64]:
    """Return the indices of a longest increasing subsequence."""
    tails: list[float] = []
    ends: list[int] = []
    before = np.full(len(times), -1, dtype=np.int64)
    for i, t in enumerate(times.tolist()):
        at = bisect_left(tails, t)
        if at:
            before[i] = ends[at - 1]
        if at == len(tails):
            tails.append(t)
            ends.append(i)
        elif tails[at] > t:  # of equal ones the first is kept
            tails[at], ends[at] = t, i
    found = []
    i = ends[-1]
    while i >= 0:
        found.append(i)
        i = int(before[i])
    return np.array(found[::-1], dtype=np.int64)


def _gaps(times: Array) -> tuple[str, ...]:
    steps = np.diff(times)
    if not len(steps) or float(steps.max()) <= LEAST_GAP_S:
        return ()
    gaps = np.flatnonzero(steps > max(GAP_STEPS * float(np.median(steps)), LEAST_GAP_S))
    if not len(gaps):
        return ()
    worst = gaps[np.argmax(steps[gaps])]
    return (
        f"{counted(len(gaps), 'gap')}, the longest of {steps[worst]:.3g} s at {times[worst]:.6g} s",
    )
