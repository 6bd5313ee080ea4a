"""What a watched run has to say: of whom, from when to when, and in sentences."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimation.history_rows import first_rows
from estimation.history_view import HistoryView
from estimation.status import Status
from estimation.watch.flags import Flag
from models.arrays import Array

FLAGGED = "sensor flagged"
MOST_SPANS = 3
"""That a sentence names; of more it says how many."""

OF_THE_WHOLE: Mapping[Status, str] = {
    Status.LOST: "lost",
    Status.INCONSISTENT: "inconsistent, no cause found",
    Status.LIVELIER: "livelier than the model says, process noise grew",
}
"""What is said of no single sensor, as a sentence begins."""


def spans(time_s: Array, holds: NDArray[np.bool_]) -> Array:
    """Return (k, 2) from when to when something holds: up to the first step where it does not.

    What holds at the last step ends there.

    Parameters
    ----------
    time_s, holds : (n,) of successive steps
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]])))
    firsts, behind = edges[::2], np.minimum(edges[1::2], len(time_s) - 1)
    return np.column_stack([time_s[firsts], time_s[behind]])


def shaded_spans(history: HistoryView) -> dict[str, Array]:
    """Return what a drawing shades, (k, 2) from when to when, by what it says of it."""
    rows = first_rows(history.time_s)
    time_s = history.time_s[rows]
    found = {status.label: spans(time_s, _has(history, status)[rows]) for status in OF_THE_WHOLE}
    found[FLAGGED] = spans(time_s, history.flagged[rows].any(axis=1))
    return {word: of_it for word, of_it in found.items() if len(of_it)}


def watch_sentences(history: HistoryView) -> list[str]:
    """Say what a watch said: what of which sensor and when, when it was lost and found again.

    Empty where nobody watched.
    """
    if not history.sensor_names or not len(history.time_s):
        return []
    rows = first_rows(history.time_s)
    time_s = history.time_s[rows]
    holds = {word: _has(history, status)[rows] for status, word in OF_THE_WHOLE.items()}
    for name, flags in zip(history.sensor_names, history.flagged[rows].T, strict=True):
        holds |= {
            f"{name} {flag.word.replace('_', ' ')}": (flags & flag.value) != 0 for flag in Flag
        }
    told = [
        f"{word}: {_when(spans(time_s, where), time_s[-1])}"
        for word, where in holds.items()
        if where.any()
    ]
    return told or ["watched: nothing was flagged, nothing was lost"]


def _has(history: HistoryView, member: Status) -> NDArray[np.bool_]:
    known = {status: member in status for status in set(history.status)}
    return np.array([known[status] for status in history.status], dtype=bool)


def _when(of_it: Array, end_s: float) -> str:
    ends = ["the end" if end == end_s else f"{end:.4g} s" for _, end in of_it[:MOST_SPANS]]
    named = [f"from {start:.4g} s to {end}" for (start, _), end in zip(of_it, ends, strict=False)]
    if len(of_it) > MOST_SPANS:
        named.append(f"… {len(of_it)} times")
    in_all = f"; {(of_it[:, 1] - of_it[:, 0]).sum():.3g} s in all" if len(of_it) > 1 else ""
    return ", ".join(named) + in_all
