"""Windows of time in a row of stamps: where they begin, which samples each has, its longest gap."""

from __future__ import annotations

import numpy as np

from models.arrays import Array


def window_starts(time_s: Array, length_s: float, *, most: int) -> Array:
    """Return where half-overlapping windows begin (w,), only where there are samples.

    Parameters
    ----------
    time_s : (n,) increasing, at least one
    most : windows; of more, so many are taken, evenly
    """
    steps = np.unique(np.floor((time_s - time_s[0]) / (length_s / 2)))
    if len(steps) > most:
        steps = steps[np.linspace(0, len(steps) - 1, most).astype(int)]
    return np.asarray(time_s[0] + steps * length_s / 2)


def window_rows(time_s: Array, start_s: Array, length_s: float) -> list[slice]:
    """Return the samples of each window.

    Parameters
    ----------
    time_s : (n,) increasing
    start_s : (w,) where windows begin
    """
    first, end = np.searchsorted(time_s, [start_s, start_s + length_s])
    return list(map(slice, first.tolist(), end.tolist()))


def longest_gaps_s(time_s: Array, start_s: Array, length_s: float) -> Array:
    """Return the longest time (w,) without a sample in each window, its ends included.

    Parameters
    ----------
    time_s : (n,) increasing
    start_s : (w,) where windows begin
    """
    first, end = np.searchsorted(time_s, [start_s, start_s + length_s])
    found, some = np.full(len(start_s), length_s), end > first
    if not some.any():
        return found
    first, last, start = first[some], end[some] - 1, start_s[some]
    # The largest of the steps of each window; what lies between windows is not taken.
    steps = np.append(np.diff(time_s), 0.0)
    within = np.maximum.reduceat(steps, np.column_stack([first, last]).ravel())[::2]
    at_ends = np.maximum(time_s[first] - start, start + length_s - time_s[last])
    found[some] = np.maximum(at_ends, np.where(last > first, within, 0.0))
    return found
