"""``pen-mhe estimate``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from benchmark.console import console
from benchmark.runner.interrupts import not_swallowed
from commands.option_groups import fields_group, grouped
from commands.options import PenOrNoneOption, SensorsOption, WritingAreaOption, names
from commands.options import units as read_units
from commands.recording_options import FileOptions
from commands.sentences import ExitCode, one_sentence
from commands.setting_options import check_options, settings_group
from estimation.apart import check_apart
from estimation.progress_bar import progress
from estimation.watch.config import ON_LOST
from models.errors import InputError
from models.pen_file import load_pen, pen_paths
from pen_mhe.estimators import DEFAULT_ESTIMATOR, ESTIMATORS
from pen_mhe.no_pen.usual import WITHOUT_PEN, usual_estimator
from pen_mhe.truth.frame_names import FRAMES

if TYPE_CHECKING:
    from pen_mhe.truth.given import GivenTruth
    from recordings.thinning import CameraThinning

EstimatorName = StrEnum("EstimatorName", {name: name for name in ESTIMATORS})  # type: ignore[misc]
OnLostName = StrEnum("OnLostName", {name: name for name in ON_LOST})  # type: ignore[misc]
TruthFrameName = StrEnum("TruthFrameName", {name: name for name in FRAMES})  # type: ignore[misc]


@dataclass(frozen=True, kw_only=True)
class Source(FileOptions):
    """A recording, the pen that wrote it or its axis, and whether rest is a reading."""

    pen: PenOrNoneOption = None
    axis: Annotated[
        str | None,
        typer.Option(
            help="Without --pen: the sensor's axis that points along the pen from tip to top, "
            "x, -x, y, -y, z, -z, or three numbers; by default as motion or gravity shows."
        ),
    ] = None
    sensors: SensorsOption = None
    writing_area: WritingAreaOption = True
    rest: Annotated[
        bool,
        typer.Option(
            help="Take a pen that does not move for one that does not turn: by the pen file's "
            "sensor of rest, or one of its own where the recording is still."
        ),
    ] = True


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
class Watching:
    """Whether readings are tested, and what is done where the estimate is lost."""

    watch: Annotated[
        bool | None,
        typer.Option(
            "--watch/--no-watch",
            help="Test readings, leave out sensors that lie, start again where lost; by default, "
            "unless --smooth.",
        ),
    ] = None
    on_lost: Annotated[
        OnLostName | None,
        typer.Option(help="Start again from the prior, or only say so; restart by default."),
    ] = None


@dataclass(frozen=True, kw_only=True)
class TruthOptions:
    """A truth from elsewhere, and what is known of its clock and frame."""

    truth: Annotated[
        Path | None,
        typer.Option(
            help="Motion capture, a tablet or angles to compare with, in any format that is read. "
            "The recording is then read whole."
        ),
    ] = None
    truth_offset: Annotated[
        float | None, typer.Option(help="Added to the truth's times, s; by default it is found.")
    ] = None
    truth_frame: Annotated[
        TruthFrameName | None,
        typer.Option(
            help="The truth's frame is the same, level (turned about the vertical), or free; by "
            "default what fits."
        ),
    ] = None

    truth_columns: Annotated[
        str | None,
        typer.Option(
            help="Which of its columns are which, e.g. 'position=a,b,-c;time=t': position, "
            "quaternion (x, y, z, w), azimuth, elevation, spin, down, time; or the names of all "
            "of a file without a header."
        ),
    ] = None
    truth_units: Annotated[
        str | None,
        typer.Option(
            help="Units of its columns where their headers have none: position=mm,time=ms."
        ),
    ] = None

    def given(self) -> GivenTruth | None:
        """Return what the estimate is compared with; None for nothing."""
        from pen_mhe.truth.given import GivenTruth

        frame = self.truth_frame and self.truth_frame.value
        return GivenTruth.of(
            self.truth,
            offset_s=self.truth_offset,
            frame=frame,
            columns=self.truth_columns,
            units=read_units(self.truth_units),
        )


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
    watching=fields_group(Watching),
    compared=fields_group(TruthOptions),
)
def estimate(
    source: Source,
    written: Written,
    estimator: Annotated[
        EstimatorName | None,
        typer.Option(help=f"By default {DEFAULT_ESTIMATOR}, without --pen {WITHOUT_PEN}."),
    ] = None,
    *,
    settings: dict[str, Any],
    part: UsedPart,
    watching: Watching,
    compared: TruthOptions,
) -> None:
    """Estimate the motion of a pen from a recording.

    Writes one row per IMU sample: time_s, the states, their standard
    deviations (…_std), status, not_observable (tip_x_m+azimuth_rad: what
    no reading shows), flagged (accel:stuck+camera:outlier), iterations and
    step_time_s; where a row was told later than the instant
    it speaks of, arrival_s too. Beside a --truth each quantity has its true
    value and its error. Readings are tested (--no-watch does not).
    CSV and Parquet with columns like these may be of any length: they are
    read and written in parts. What any other logger wrote is read whole.
    The recording is checked first (pen-mhe check); the last line says how far
    to trust the answer. Ends with 1 where it cannot be meant.
    """
    # Tables and figures are slow to import: only where a command needs them.
    from pen_mhe.estimate_file import estimate_file

    chosen = usual_estimator(source.pen) if estimator is None else estimator.value
    with one_sentence():
        check_options(chosen, settings)
        check_apart(
            [written.output, written.figure],
            {
                "the recording": source.recording,
                "the pen file": () if source.pen is None else pen_paths(source.pen),
                "the truth": [compared.truth],
            },
        )
        with not_swallowed():
            summary = estimate_file(
                source.recording,
                None if source.pen is None else load_pen(source.pen),
                written.output,
                axis=source.axis,
                figure=written.figure,
                units=read_units(source.units),
                columns=source.columns,
                strict=source.strict,
                reporting=progress,
                estimator=chosen,
                settings=settings,
                sensors=names(source.sensors),
                thinning=part.thinning(),
                duration_s=part.duration,
                writing_area=source.writing_area,
                rest=source.rest,
                smooth=part.smooth,
                causal=part.causal,
                watch=watching.watch,
                on_lost=watching.on_lost and watching.on_lost.value,
                truth=compared.given(),
            )
        console.print(f"{summary.size}, written to {written.output}")
        for sentence in summary.sentences():
            console.print(sentence)
    if not summary.trust.is_meant:
        raise typer.Exit(ExitCode.NOT_MEANT)
