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
    whole = WatchInParts()
    whole.add(history)
    return whole.sentences()


class WatchInParts:
    """`watch_sentences` of a history that comes in parts."""

    def __init__(self) -> None:
        self._end_s, self._is_watched = -np.inf, False
        self._spans: dict[str, _Spans] = {}

    def add(self, history: HistoryView) -> None:
        """Take the next steps."""
        rows = first_rows(history.time_s)
        rows = rows[history.time_s[rows] > self._end_s]
        if not history.sensor_names or not len(rows):
            return
        time_s, self._is_watched = history.time_s[rows], True
        holds = {word: _has(history, status)[rows] for status, word in OF_THE_WHOLE.items()}
        for name, flags in zip(history.sensor_names, history.flagged[rows].T, strict=True):
            holds |= {
                f"{name} {flag.word.replace('_', ' ')}": (flags & flag.value) != 0 for flag in Flag
            }
        for word, where in holds.items():
            self._spans.setdefault(word, _Spans()).add(time_s, where)
        self._end_s = float(time_s[-1])

    def sentences(self) -> list[str]:
        """Return what it said until now."""
        told = [
            f"{word}: {of_it.when(self._end_s)}" for word, of_it in self._spans.items() if of_it.any
        ]
        nothing = ["watched: nothing was flagged, nothing was lost"] if self._is_watched else []
        return told or nothing


class _Spans:
    """Spans of successive steps in which something holds, of which only the first few are kept."""

    def __init__(self) -> None:
        self._first: list[tuple[float, float]] = []
        self._count, self._in_all_s = 0, 0.0
        self._since_s: float | None = None

    @property
    def any(self) -> bool:
        """Whether it held at any step."""
        return self._count > 0 or self._since_s is not None

    def add(self, time_s: Array, holds: NDArray[np.bool_]) -> None:
        """Take the next steps (n,), at least one."""
        held = self._since_s is not None
        edges = time_s[np.flatnonzero(np.diff(np.append(held, holds)))]
        if self._since_s is not None:
            edges = np.append(self._since_s, edges)
        closed = edges[: len(edges) // 2 * 2].reshape(-1, 2)
        self._since_s = float(edges[-1]) if len(edges) % 2 else None
        self._first += [(float(a), float(b)) for a, b in closed[: MOST_SPANS - len(self._first)]]
        self._count, self._in_all_s = (
            self._count + len(closed),
            self._in_all_s + float((closed[:, 1] - closed[:, 0]).sum()),
        )

    def when(self, end_s: float) -> str:
        """Say when it held; what holds at the last step, `end_s`, ends there."""
        first, count, in_all_s = list(self._first), self._count, self._in_all_s
        if self._since_s is not None:
            first, count = [*first, (self._since_s, end_s)], count + 1
            in_all_s += end_s - self._since_s
        named = [
            f"from {start:.4g} s to {'the end' if end == end_s else f'{end:.4g} s'}"
            for start, end in first[:MOST_SPANS]
        ]
        if count > MOST_SPANS:
            named.append(f"… {count} times")
        return ", ".join(named) + (f"; {in_all_s:.3g} s in all" if count > 1 else "")


def _has(history: HistoryView, member: Status) -> NDArray[np.bool_]:
    known = {status: member in status for status in set(history.status)}
    return np.array([known[status] for status in history.status], dtype=bool)
