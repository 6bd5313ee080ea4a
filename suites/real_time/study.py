"""The work behind ``pen-mhe real-time``: kept factors, deadlines, time per sample."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from benchmark.console import console, print_table, progress
from benchmark.report.numbers import in_unit
from estimation.output_folder import prepare_folder
from mhe.reuse import REUSE_THRESHOLD
from pen_mhe.figures import save
from suites.real_time.deadlines import DeadlineRow, deadline_rows, total_steps
from suites.real_time.reuse import ReuseRow, reuse_rows
from suites.real_time.sample_times import TimeRow, time_rows
from suites.real_time.streams import CASES, available

CLOSE_STD = 0.05
RATIOS: Mapping[int, float] = {20: 1 / 2, 100: 1 / 3}
"""What kept factors are held against: distance, and time by horizon."""
DEADLINE_CASE, RECORDED_CASE = "pen24", "dpoint-30"


def run_real_time(output: Path, data: Path | None, steps: int) -> None:
    """Run all parts; print tables, write ``real_time.json`` and ``real_time_reuse.png``."""
    prepare_folder(output)
    cases = available(data)
    if len(cases) < len(CASES):
        console.print(
            "real recordings: left out, they need a folder (--data FOLDER, or the variable "
            "PEN_MHE_DATA)"
        )
    reuse: list[ReuseRow] = []
    with progress("factors that stay") as start:
        done = start(len(cases))
        for name, case in cases.items():
            reuse += reuse_rows(name, case.stream(data))
            done(1)
    with progress("deadlines") as start:
        stream = cases[DEADLINE_CASE].stream(data)
        deadlines = deadline_rows(stream, steps, start(total_steps(steps)))
    times = time_rows(cases[RECORDED_CASE].stream(data)) if RECORDED_CASE in cases else []
    _print_reuse(reuse)
    _print_deadlines(deadlines)
    _print_times(times)
    parts: dict[str, Sequence[Any]] = {"reuse": reuse, "deadlines": deadlines, "times": times}
    listed = {part: [_plain(row) for row in rows] for part, rows in parts.items()}
    (output / "real_time.json").write_text(
        json.dumps(listed, indent=1, allow_nan=False) + "\n", "utf-8"
    )
    save(reuse_figure(reuse), output / "real_time_reuse.png")
    console.print(f"\nreal_time.json and real_time_reuse.png in {output}")


def _plain(row: Any) -> dict[str, Any]:
    """Return a row for JSON, which knows no infinity."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in dataclasses.asdict(row).items()
    }


def _print_reuse(rows: Sequence[ReuseRow]) -> None:
    columns = ["stream", "N", "contender", "RMS / σ", "max / σ", "stages kept", "time"]
    texts = [
        [
            CASES[row.case].label,
            str(row.horizon),
            row.contender + (" (default)" if row.threshold == REUSE_THRESHOLD else ""),
            f"{row.rms_std:.3f}",
            f"{row.max_std:.2f}",
            f"{row.reused:.0%}",
            f"{row.time_ratio:.2f}",
        ]
        for row in rows
    ]
    print_table("Factors that stay: newest state and time beside full passes", columns, texts)


def _print_deadlines(rows: Sequence[DeadlineRow]) -> None:
    columns = ["estimator", "deadline", "steps", "in time", "worst overrun"]
    columns += ["predicted", "stopped", "solved"]
    texts = [
        [
            row.estimator,
            in_unit(row.deadline_s),
            str(row.steps),
            f"{row.in_time:.3%}",
            in_unit(row.worst_overrun_s) if row.worst_overrun_s else "none",
            f"{row.predicted:.2%}",
            f"{row.limited:.2%}",
            f"{row.solved:.2%}",
        ]
        for row in rows
    ]
    print_table("\nDeadlines, by the real clock", columns, texts)


def _print_times(rows: Sequence[TimeRow]) -> None:
    columns = ["D-POINT, camera at 30 Hz", "samples", "median", "p99", "longest", "with a frame"]
    times = ("median_s", "p99_s", "max_s", "frame_median_s")
    texts = [
        [row.contender, str(row.samples), *(in_unit(getattr(row, name)) for name in times)]
        for row in rows
    ]
    if texts:
        print_table("\nTime per sample of the real recording", columns, texts)


def reuse_figure(rows: Sequence[ReuseRow]) -> Figure:
    """Draw distance and time over the threshold, one column per horizon."""
    horizons = sorted({row.horizon for row in rows})
    figure, axes = plt.subplots(
        2,
        len(horizons),
        figsize=(4.6 * len(horizons), 6.4),
        layout="constrained",
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    judged = [name for name, case in CASES.items() if case.is_judged]
    for column, horizon in enumerate(horizons):
        distance, time = axes[:, column]
        for i, name in enumerate(judged):
            found = [
                row
                for row in rows
                if (row.case, row.horizon) == (name, horizon)
                and row.threshold
                and math.isfinite(row.threshold)
            ]
            thresholds = [row.threshold for row in found]
            style = {"color": f"C{i}", "marker": "o", "ms": 4, "label": CASES[name].label}
            distance.loglog(thresholds, [row.rms_std for row in found], **style)
            time.semilogx(thresholds, [row.time_ratio for row in found], **style)
        distance.axhline(CLOSE_STD, color="0.4", ls="--", lw=1)
        distance.set(title=f"N = {horizon}")
        time.axhline(RATIOS.get(horizon, 1.0), color="0.4", ls="--", lw=1)
        time.set(xlabel="threshold / posterior standard deviations", ylim=(0, None))
        for panel in (distance, time):
            panel.axvline(REUSE_THRESHOLD, color="0.7", lw=1)
    axes[0, 0].set(ylabel="newest state, RMS distance from\nfull passes / standard deviations")
    axes[1, 0].set(ylabel="time per step / that of full passes")
    axes[1, -1].legend(fontsize="small", loc="upper right")
    return figure
