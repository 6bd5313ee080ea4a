"""``pen-mhe estimate``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from benchmark.console import console, progress
from commands.options import PenOption, SensorsOption, WritingAreaOption, names, thresholds
from commands.options import units as read_units
from commands.sentences import one_sentence
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.config import MheConfig
from models.errors import InputError
from models.pen_file import load_pen
from pen_mhe.estimators import DEFAULT_ESTIMATOR, ESTIMATORS, EstimatorSettings

if TYPE_CHECKING:
    from pen_mhe.estimate_run import EstimateRun

EstimatorName = StrEnum("EstimatorName", {name: name for name in ESTIMATORS})  # type: ignore[misc]
ArrivalCostName = StrEnum(  # type: ignore[misc]
    "ArrivalCostName", {name: name for name in ARRIVAL_COSTS}
)
MHE = MheConfig()
DEFAULT = EstimatorName(DEFAULT_ESTIMATOR)
FILTERED = ArrivalCostName("filtered")


def estimate(
    recording: Annotated[
        Path, typer.Argument(help="A D-POINT folder, or a .csv or .parquet file.")
    ],
    pen: PenOption,
    output: Annotated[Path, typer.Option(help="Table to write, .parquet or .csv.")],
    sensors: SensorsOption = None,
    writing_area: WritingAreaOption = True,
    estimator: Annotated[EstimatorName, typer.Option()] = DEFAULT,
    figure: Annotated[Path | None, typer.Option(help="Figure to write, .png.")] = None,
    horizon: Annotated[int, typer.Option(help="Intervals in the window of an MHE.")] = MHE.horizon,
    arrival_cost: Annotated[ArrivalCostName, typer.Option()] = FILTERED,
    huber: Annotated[
        str | None,
        typer.Option(help="Huber's loss of an MHE on sensors, in deviations: accel=2,camera=3."),
    ] = None,
    sparse_noise: Annotated[
        float | None,
        typer.Option(help="Huber's loss of an MHE on its process noise, in deviations."),
    ] = None,
    max_iterations: Annotated[int, typer.Option(help="Of the MHE's solver, per step.")] = (
        MHE.max_iterations
    ),
    deadline: Annotated[
        float | None, typer.Option(help="Of the MHE: s per step, the best so far is returned.")
    ] = None,
    reuse: Annotated[
        float | None,
        typer.Option(help="Of mhe-rti: threshold in σ below which factors stay; 0 has none."),
    ] = None,
    camera_rate: Annotated[float | None, typer.Option(help="Use fewer frames: Hz.")] = None,
    camera_phase: Annotated[int, typer.Option(help="Which of the frames to keep.")] = 0,
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None,
    units: Annotated[
        str | None,
        typer.Option(help="Units of a table's columns, e.g. accel=g,gyro=deg_s; SI by default."),
    ] = None,
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
    from recordings.thinning import CameraThinning

    with one_sentence():
        prepare_output(output)
        if figure is not None:
            prepare_output(figure, FIGURE_SUFFIXES)
        config = load_pen(pen)
        loaded = read_written(recording, config, units=read_units(units))
        settings = EstimatorSettings(
            mhe=MheConfig(
                horizon=horizon,
                arrival_cost=arrival_cost.value,
                huber=thresholds(huber),
                sparse_noise=sparse_noise,
                max_iterations=max_iterations,
                deadline_s=deadline,
                reuse_threshold=reuse,
            )
        )
        thinning = CameraThinning(camera_rate, camera_phase) if camera_rate is not None else None
        if thinning is None and camera_phase != 0:
            raise InputError("camera phase given without --camera-rate, expected both")
        with progress(estimator.value) as start:
            result = estimate_recording(
                loaded,
                config,
                estimator.value,
                names(sensors),
                settings,
                thinning,
                duration,
                start,
                writing_area,
            )
        write_table(result.output.to_pandas(), output)
        if figure is not None:
            save(estimate_figure(result.output, result.ink, result.used.truth), figure)
        _report(result, output)


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
