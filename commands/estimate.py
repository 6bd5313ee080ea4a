"""``pen-mhe estimate``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from benchmark.console import console, progress
from commands.option_groups import fields_group, grouped
from commands.options import PenOption, SensorsOption, WritingAreaOption, names
from commands.options import units as read_units
from commands.sentences import one_sentence
from commands.setting_options import check_options, settings_group
from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimators import DEFAULT_ESTIMATOR, ESTIMATORS

if TYPE_CHECKING:
    from pen_mhe.estimate_run import EstimateRun
    from recordings.thinning import CameraThinning

EstimatorName = StrEnum("EstimatorName", {name: name for name in ESTIMATORS})  # type: ignore[misc]
DEFAULT = EstimatorName(DEFAULT_ESTIMATOR)


@dataclass(frozen=True, kw_only=True)
class Source:
    """A recording and the pen that wrote it."""

    recording: Annotated[Path, typer.Argument(help="A D-POINT folder, or a .csv or .parquet file.")]
    pen: PenOption
    sensors: SensorsOption = None
    writing_area: WritingAreaOption = True
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. accel=g,gyro=deg_s; SI by default."),
    ] = None


@dataclass(frozen=True, kw_only=True)
class UsedPart:
    """How much of a recording is used."""

    camera_rate: Annotated[float | None, typer.Option(help="Use fewer frames: Hz.")] = None
    camera_phase: Annotated[int, typer.Option(help="Which of the frames to keep.")] = 0
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None

    def thinning(self) -> CameraThinning | None:
        """Return which frames are used; None for all."""
        from recordings.thinning import CameraThinning

        if self.camera_rate is not None:
            return CameraThinning(self.camera_rate, self.camera_phase)
        if self.camera_phase != 0:
            raise InputError("camera phase given without --camera-rate, expected both")
        return None


@dataclass(frozen=True, kw_only=True)
class Written:
    """What is written."""

    output: Annotated[Path, typer.Option(help="Table to write, .parquet or .csv.")]
    figure: Annotated[Path | None, typer.Option(help="Figure to write, .png.")] = None


@grouped(
    source=fields_group(Source),
    written=fields_group(Written),
    settings=settings_group(),
    part=fields_group(UsedPart),
)
def estimate(
    source: Source,
    written: Written,
    estimator: Annotated[EstimatorName, typer.Option()] = DEFAULT,
    *,
    settings: dict[str, Any],
    part: UsedPart,
) -> None:
    """Estimate the motion of a pen from a recording.

    Writes one row per IMU sample: time_s, the states, their standard
    deviations (…_std), status, iterations and step_time_s.
    """
    # Tables and figures are slow to import: only where a command needs them.
    from pen_mhe.estimate_run import estimate_recording
    from pen_mhe.figures import FIGURE_SUFFIXES, estimate_figure, save
    from recordings.formats.tables import prepare_output, write_table
    from recordings.read import read_written

    with one_sentence():
        check_options(estimator.value, settings)
        prepare_output(written.output)
        if written.figure is not None:
            prepare_output(written.figure, FIGURE_SUFFIXES)
        pen = load_pen(source.pen)
        loaded = read_written(source.recording, pen, units=read_units(source.units))
        thinning = part.thinning()
        with progress(estimator.value) as start:
            result = estimate_recording(
                loaded,
                pen,
                estimator=estimator.value,
                settings=settings,
                sensors=names(source.sensors),
                thinning=thinning,
                duration_s=part.duration,
                on_start=start,
                writing_area=source.writing_area,
            )
        write_table(result.output.to_pandas(), written.output)
        if written.figure is not None:
            save(
                estimate_figure(result.output, result.ink, truth=result.used.truth), written.figure
            )
        _report(result, written.output)


def _report(result: EstimateRun, output: Path) -> None:
    history, steps_ms = result.history, result.history.step_time_s * 1e3
    console.print(f"{len(result.output)} samples, {len(history)} steps, written to {output}")
    console.print(f"solved {history.solved_fraction:.2%} of the steps")
    remarks = [status for status in history.status if status.label != "solved"]
    for status in dict.fromkeys(remarks):
        console.print(f"{remarks.count(status)} × {status.label}: {status.sentence}")
    console.print(
        f"step time: median {np.median(steps_ms):.3g} ms, p99 {np.quantile(steps_ms, 0.99):.3g} ms"
    )
    if result.zero_delay:
        console.print(
            f"zero delay: readings of {', '.join(result.zero_delay)} are used at the instant of "
            "their stamp, taken as that of capture; figures do not compare with causal ones"
        )
    if result.left_out is not None:
        errors = ", ".join(
            _in_readable_unit(unit, rms) for unit, rms in result.left_out.rms.items()
        )
        console.print(f"RMS error against {result.left_out.frames} frames left out: {errors}")
    if result.true_rms:
        errors = ", ".join(
            f"{column} {value:.4g}" if isinstance(value, float) else f"{column} {value}"
            for column, value in result.true_rms.items()
        )
        console.print(f"RMS error against the truth: {errors}")
    for name, found in (("NIS of the innovations", result.nis), ("NEES", result.nees)):
        if found is not None:
            console.print(
                f"{name}: mean {found.mean:.4g}, expected {found.expected:.4g} "
                f"(95 % of consistent runs: {found.lower:.4g} to {found.upper:.4g}, "
                "if instants were independent)"
            )
    if result.ink is not None:
        console.print(f"mean ink distance: {result.ink.mean_distance_mm:.4f} mm")


def _in_readable_unit(unit: str, value: float) -> str:
    return f"{value * 1e3:.3f} mm" if unit == "m" else f"{np.degrees(value):.3f}°"
