"""``pen-mhe estimate``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from benchmark.console import console, progress
from benchmark.runner.interrupts import not_swallowed
from commands.option_groups import fields_group, grouped
from commands.options import RestOption, names
from commands.options import units as read_units
from commands.recording_options import RecordingOptions
from commands.sentences import one_sentence
from commands.setting_options import check_options, settings_group
from estimation.apart import check_apart
from models.errors import InputError
from models.pen_file import load_pen, pen_paths
from pen_mhe.estimators import DEFAULT_ESTIMATOR, ESTIMATORS

if TYPE_CHECKING:
    from pen_mhe.run_result import EstimateRun
    from recordings.thinning import CameraThinning

EstimatorName = StrEnum("EstimatorName", {name: name for name in ESTIMATORS})  # type: ignore[misc]
DEFAULT = EstimatorName(DEFAULT_ESTIMATOR)


@dataclass(frozen=True, kw_only=True)
class Source(RecordingOptions):
    """A recording, the pen that wrote it, and whether rest is a reading."""

    rest: RestOption = True


@dataclass(frozen=True, kw_only=True)
class UsedPart:
    """How much of a recording is used, in which order, and whether in both directions."""

    camera_rate: Annotated[float | None, typer.Option(help="Use fewer frames: Hz.")] = None
    camera_phase: Annotated[int, typer.Option(help="Which of the frames to keep.")] = 0
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None
    causal: Annotated[
        bool, typer.Option("--causal", help="Use readings when they arrive, not at capture.")
    ] = False
    smooth: Annotated[
        bool, typer.Option("--smooth", help="Go back over a filter's estimates from the end.")
    ] = False

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
    deviations (…_std), status, iterations and step_time_s; where a row
    was told later than the instant it speaks of, arrival_s too.
    """
    # Tables and figures are slow to import: only where a command needs them.
    from pen_mhe.estimate_run import estimate_recording
    from pen_mhe.figures import FIGURE_SUFFIXES, estimate_figure, save
    from recordings.formats.tables import check_output, write_table
    from recordings.read import read_written

    with one_sentence():
        check_options(estimator.value, settings)
        check_apart(
            [written.output, written.figure],
            {"the recording": source.recording, "the pen file": pen_paths(source.pen)},
        )
        check_output(written.output)
        if written.figure is not None:
            check_output(written.figure, FIGURE_SUFFIXES)
        pen = load_pen(source.pen)
        loaded = read_written(
            source.recording,
            pen,
            units=read_units(source.units),
            columns=source.columns,
            strict=source.strict,
        )
        thinning = part.thinning()
        with progress(estimator.value) as start, not_swallowed():
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
                rest=source.rest,
                smooth=part.smooth,
                causal=part.causal,
            )
        write_table(result.output.to_pandas(), written.output)
        if written.figure is not None:
            save(
                estimate_figure(result.output, result.ink, truth=result.used.truth), written.figure
            )
        _report(result, written.output)


def _report(result: EstimateRun, output: Path) -> None:
    samples = f"{len(result.output)} samples, {len(result.history)} steps"
    console.print(f"{samples}, written to {output}")
    for sentence in result.sentences():
        console.print(sentence)
