"""Many rows: in chunks where nothing stands out, else one by one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from estimation.collect import BATCH_STEPS
from estimation.estimate import Estimate, EstimateHistory
from estimation.recording import Measurement
from estimation.watch.clean_rows import CleanRows
from estimation.watch.state import WatchState
from models.arrays import Array

GROWTH = 4
"""By how much a chunk is longer than one that was clean; behind something that was found it is as
long as what was clean before it, so that little is estimated for nothing."""


def in_chunks(
    state: WatchState,
    time_s: Array,
    y: Array,
    *,
    clean: CleanRows,
    look: Callable[[WatchState, Measurement], tuple[WatchState, Estimate]],
    collect: Callable[[list[Estimate], list[float]], EstimateHistory],
    covariances: bool,
    on_progress: Callable[[int], None] | None,
) -> tuple[WatchState, EstimateHistory]:
    """Take n rows; return the state and the history behind them.

    Parameters
    ----------
    time_s, y, covariances, on_progress : see `estimation.watch.watched.Watched.batch`
    clean : takes chunks
    look : takes a row in which something stands out
    collect : from such estimates, and how long each took in s, to their history
    """
    n, after = len(time_s), state
    estimates, times = list[Estimate](), list[float]()

    def gathered() -> EstimateHistory:
        """Return the history of what was looked at, which is then forgotten."""
        part = collect(estimates, times)
        estimates.clear()
        times.clear()
        return part

    def parts() -> Iterator[EstimateHistory]:
        nonlocal after
        done, size = 0, BATCH_STEPS
        while done < n:
            before, rows = done, slice(done, min(done + size, n))
            if clean.may_take(after):
                after, part = clean.taken(after, time_s[rows], y[rows], covariances)
                if part is not None:
                    if estimates:
                        yield gathered()
                    yield part
                    done += len(part)
                is_whole = done == rows.stop
                size = min(GROWTH * size, BATCH_STEPS) if is_whole else max(done - before, 1)
            if done < rows.stop:
                began = time.perf_counter()
                row = Measurement(float(time_s[done]), y[done])
                after, estimate = look(after, row)
                times.append(time.perf_counter() - began)
                estimates.append(estimate)
                done += 1
                if len(estimates) == BATCH_STEPS:
                    yield gathered()
            if on_progress:
                on_progress(done - before)
        if estimates or not n:
            yield gathered()

    history = EstimateHistory.joined(parts(), n)
    return after, history
