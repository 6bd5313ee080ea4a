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

from benchmark.console import console, print_table
from benchmark.report.numbers import in_unit
from benchmark.runner.about import timing_identity
from benchmark.runner.kept import Jobs, kept_results
from benchmark.tasks.suite import Scope
from estimation.output_file import write_whole
from estimation.output_folder import check_folder
from mhe.reuse import REUSE_THRESHOLD
from pen_mhe.figures import save
from suites.real_time.deadlines import DeadlineRow
from suites.real_time.late_times import ORDERS, LateRow
from suites.real_time.parts import PARTS, Part, parts_of, run_part
from suites.real_time.reuse import HORIZONS, THRESHOLDS, ReuseRow
from suites.real_time.sample_times import TimeRow
from suites.real_time.streams import CASES, FOLDER, available

CLOSE_STD = 0.05
RATIOS: Mapping[int, float] = {20: 1 / 2, 100: 1 / 3}
"""What kept factors are held against: distance, and time by horizon."""


def run_real_time(
    output: Path,
    data: Path | None,
    steps: int,
    *,
    horizons: Sequence[int] = HORIZONS,
    thresholds: Sequence[float] = THRESHOLDS,
) -> None:
    """Run all parts; print tables, write ``real_time.json`` and ``real_time_reuse.png``.

    Parameters
    ----------
    output : folder to write to
    data, steps, horizons, thresholds : of `suites.real_time.parts.parts_of`
    """
    check_folder(output)
    if len(available(data)) < len(CASES):
        console.print(
            "real recordings: left out, they need a folder (--data FOLDER, or the variable "
            "PEN_MHE_DATA)"
        )
    measured = parts_of(data, steps, horizons, thresholds)
    jobs = Jobs[Part](single_threaded=True)
    found = kept_results("real-time", run_part, measured, output, jobs=jobs, identity=_made_with)
    parts: dict[str, list[Any]] = {
        name: [
            row
            for part, rows in zip(measured, found, strict=True)
            if isinstance(part, kind)
            for row in rows
        ]
        for name, kind in PARTS.items()
    }
    _print_reuse(parts["reuse"])
    _print_deadlines(parts["deadlines"])
    _print_times(parts["times"])
    _print_late(parts["late"])
    listed = {name: [_plain(row) for row in rows] for name, rows in parts.items()}
    write_whole(output / "real_time.json", json.dumps(listed, indent=1, allow_nan=False) + "\n")
    save(reuse_figure(parts["reuse"]), output / "real_time_reuse.png")
    console.print(f"\nreal_time.json and real_time_reuse.png in {output}")


def _made_with(part: Part) -> str:
    folder = "" if part.data is None else FOLDER
    return timing_identity(folder, Scope(data=None if part.data is None else str(part.data)))


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


def _print_late(rows: Sequence[LateRow]) -> None:
    columns = ["D-POINT, camera at 30 Hz", "frames", "samples", "median", "mean", "p99"]
    columns += ["with a frame", "mean / at capture"]
    at_capture = {row.contender: row.mean_s for row in rows if row.frames == ORDERS[0]}
    times = ("median_s", "mean_s", "p99_s", "with_frame_s")
    texts = [
        [
            *(row.contender, row.frames, str(row.samples)),
            *(in_unit(getattr(row, name)) for name in times),
            f"{row.mean_s / at_capture[row.contender]:.2f}",
        ]
        for row in rows
    ]
    if texts:
        print_table("\nTime per sample of the IMU, frames at capture and late", columns, texts)


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
