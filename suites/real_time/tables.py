"""What the suite real-time found, as tables: means over the seeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.figures.figure import Table
from benchmark.report.numbers import in_unit
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from mhe.reuse import REUSE_THRESHOLD
from suites.real_time import deadlines, late_times, reuse, sample_times
from suites.real_time.cases import INSTANTS, LATE, deadline_case, reuse_case
from suites.real_time.deadlines import DEADLINES, KINDS
from suites.real_time.late_times import ORDERS, ordered
from suites.real_time.sample_times import FRAME, LONGEST, MEAN, MEDIAN, P99
from suites.real_time.streams import STREAMS
from suites.shared_core import SHARED_CORE

Row = tuple[str, ...]
MEANS = "Means over the seeds."
MEASURED = [OK, SHARED_CORE]
"""Statuses of tasks that have figures."""


def tables(results: Results) -> Sequence[Table]:
    """Return every table for which there are rows."""
    found: tuple[Table, ...] = (
        (
            "Factors that stay: newest state and time beside full passes",
            MEANS + " σ: standard deviations.",
            ("stream", "N", "contender", "RMS, σ", "largest, σ", "stages kept", "time"),
            _reuse(results),
        ),
        (
            "Deadlines, by the real clock",
            MEANS + " The worst overrun is that of all, also of what had to share its core.",
            (
                *("estimator", "deadline", "it is", "steps", "in time", "worst overrun"),
                *("predicted", "stopped", "solved"),
            ),
            _deadlines(results),
        ),
        (
            "Time per instant of the D-POINT recording, its camera at 30 Hz",
            MEANS,
            ("estimator", "median", "99 %", "longest", "median with a frame"),
            _instants(results),
        ),
        (
            "Time per sample of its IMU, frames at capture and as they arrive",
            MEANS,
            (
                *("estimator", "frames", "median", "mean", "99 %", "median with a frame"),
                "mean / at capture",
            ),
            _late(results),
        ),
    )
    return [table for table in found if table[-1]]


def _figures(
    results: Results, case: str, name: str, quantity: str, column: str = "bias"
) -> np.ndarray:
    rows = results.select(case=case, estimator=name, quantity=quantity, status=MEASURED)
    return np.asarray(rows[column], dtype=float)


def _mean(results: Results, case: str, name: str, quantity: str, column: str = "bias") -> float:
    return float(_figures(results, case, name, quantity, column).mean())


def _is_there(results: Results, case: str, name: str) -> bool:
    return len(results.select(case=case, estimator=name, status=MEASURED)) > 0


def _reuse(results: Results) -> list[Row]:
    return [
        (
            stream.label,
            str(N),
            name + (" (default)" if name == reuse.threshold_name(REUSE_THRESHOLD) else ""),
            f"{_mean(results, case, name, reuse.NEWEST, 'rmse'):.3f}",
            f"{_mean(results, case, name, reuse.NEWEST, 'max_error'):.2f}",
            f"{_mean(results, case, name, reuse.KEPT):.0%}",
            f"{_mean(results, case, name, reuse.TIME):.2f}",
        )
        for of, stream in STREAMS.items()
        for N in reuse.HORIZONS
        for name in reuse.CONTENDERS
        if _is_there(results, case := reuse_case(of, N), name)
    ]


def _deadlines(results: Results) -> list[Row]:
    found = []
    for name in KINDS:
        for deadline in DEADLINES:
            case = deadline_case(deadline)
            if _is_there(results, case, name):
                steps = results.select(case=case, estimator=name, quantity=deadlines.LATE)
                overrun = _figures(results, case, name, deadlines.OVERRUN).max()
                shares = (deadlines.PREDICTED, deadlines.STOPPED, deadlines.SOLVED)
                found.append(
                    (
                        name,
                        deadline.replace("-", " "),
                        in_unit(1e-6 * _mean(results, case, name, deadlines.DUE)),
                        str(int(steps["samples"].sum())),
                        f"{1 - _mean(results, case, name, deadlines.LATE):.3%}",
                        in_unit(1e-6 * overrun) if overrun else "none",
                        *(f"{_mean(results, case, name, share):.2%}" for share in shares),
                    )
                )
    return found


def _instants(results: Results) -> list[Row]:
    return [
        (name, *(_time(results, INSTANTS, name, what) for what in (MEDIAN, P99, LONGEST, FRAME)))
        for name in sample_times.CONTENDERS
        if _is_there(results, INSTANTS, name)
    ]


def _late(results: Results) -> list[Row]:
    found = []
    for name in late_times.CONTENDERS:
        if not _is_there(results, LATE, name):
            continue
        means = [_mean(results, LATE, name, MEAN + ordered(order)) for order in ORDERS]
        for order, mean in zip(ORDERS, means, strict=True):
            times = (MEDIAN, MEAN, P99, FRAME)
            texts = [_time(results, LATE, name, what + ordered(order)) for what in times]
            found.append((name, order, *texts, f"{mean / means[0]:.2f}"))
    return found


def _time(results: Results, case: str, name: str, quantity: str) -> str:
    return in_unit(1e-6 * _mean(results, case, name, quantity))
