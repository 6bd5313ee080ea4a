"""The command ``pen-mhe``."""

from __future__ import annotations

import warnings
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmark.registry import ESTIMATORS, EstimatorSettings, bundled_pens, find_pen
from benchmark.simulate import simulate_recording
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.config import MheConfig
from models.errors import InputError
from models.motions import strokes
from pen_mhe import benchmark_run, dpoint_table
from pen_mhe.console import console, one_line_warning, one_sentence, progress
from pen_mhe.estimate_run import CameraThinning, EstimateRun, estimate_recording
from pen_mhe.figures import FIGURE_SUFFIXES, estimate_figure, save
from pen_mhe.load import load_recording
from pen_mhe.tables import prepare_output, recording_to_table, write_table

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
)
EstimatorName = StrEnum("EstimatorName", {name: name for name in ESTIMATORS})  # type: ignore[misc]
ArrivalCostName = StrEnum(  # type: ignore[misc]
    "ArrivalCostName", {name: name for name in ARRIVAL_COSTS}
)
StrokeName = StrEnum("StrokeName", {name: name for name in strokes()})  # type: ignore[misc]

MHE = MheConfig()
EKF, FILTERED, TURN = EstimatorName("ekf"), ArrivalCostName("filtered"), StrokeName("turn")

PenOption = Annotated[
    str, typer.Option(help=f"Pen file, or a bundled pen: {', '.join(bundled_pens())}.")
]
SensorsOption = Annotated[
    str | None,
    typer.Option(help="Names from the pen file, with commas; by default all with readings."),
]


@app.callback()
def main() -> None:
    """Which motion sensors does a pen need, and does optimisation pay off over a Kalman filter?"""
    warnings.showwarning = one_line_warning


@app.command()
def estimate(
    recording: Annotated[
        Path, typer.Argument(help="A D-POINT folder, or a .csv or .parquet file.")
    ],
    pen: PenOption,
    output: Annotated[Path, typer.Option(help="Table to write, .parquet or .csv.")],
    sensors: SensorsOption = None,
    estimator: Annotated[EstimatorName, typer.Option()] = EKF,
    figure: Annotated[Path | None, typer.Option(help="Figure to write, .png.")] = None,
    horizon: Annotated[int, typer.Option(help="Intervals in the window of an MHE.")] = MHE.horizon,
    arrival_cost: Annotated[ArrivalCostName, typer.Option()] = FILTERED,
    max_iterations: Annotated[int, typer.Option(help="Of the MHE's solver, per step.")] = (
        MHE.max_iterations
    ),
    max_time: Annotated[float | None, typer.Option(help="Of the MHE's solver, s per step.")] = None,
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
    with one_sentence():
        prepare_output(output)
        if figure is not None:
            prepare_output(figure, FIGURE_SUFFIXES)
        config = find_pen(pen)
        loaded = load_recording(recording, config, _units(units))
        settings = EstimatorSettings(
            mhe=MheConfig(
                horizon=horizon,
                arrival_cost=arrival_cost.value,
                max_iterations=max_iterations,
                max_time_s=max_time,
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
                _names(sensors),
                settings,
                thinning,
                duration,
                start,
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
            f"zero delay: readings of {', '.join(result.zero_delay)} are used at the moment of "
            "their capture; figures do not compare with causal ones"
        )
    if result.left_out is not None:
        errors = ", ".join(
            _in_readable_unit(unit, rms) for unit, rms in result.left_out.rms.items()
        )
        console.print(f"RMS error against {result.left_out.frames} frames left out: {errors}")
    if result.true_rms:
        errors = ", ".join(f"{column} {value:.4g}" for column, value in result.true_rms.items())
        console.print(f"RMS error against the truth: {errors}")
    if result.ink is not None:
        console.print(f"mean ink distance: {result.ink.mean_distance_mm:.4f} mm")


def _in_readable_unit(unit: str, value: float) -> str:
    return f"{value * 1e3:.3f} mm" if unit == "m" else f"{np.degrees(value):.3f}°"


@app.command()
def simulate(
    output: Annotated[Path, typer.Option(help="Recording to write, .parquet or .csv.")],
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    stroke: Annotated[StrokeName, typer.Option()] = TURN,
    duration: Annotated[float, typer.Option(help="s")] = 3.0,
    seed: Annotated[int, typer.Option(help="Of the noise.", min=0)] = 0,
) -> None:
    """Write a simulated recording, with its truth in columns true_…"""
    with one_sentence():
        config = find_pen(pen)
        recording = simulate_recording(config, _names(sensors), stroke.value, duration, seed)
        write_table(recording_to_table(recording, config), output)
        console.print(f"{len(recording.time_s)} instants, written to {output}")


@app.command()
def benchmark(
    output: Annotated[Path, typer.Option(help="Folder for table and figure.")] = Path("results"),
    seed: Annotated[int, typer.Option(help="Of the noise.", min=0)] = 0,
) -> None:
    """Simulate a stroke and estimate it with every configuration and estimator."""
    with one_sentence():
        benchmark_run.run_benchmark(output, seed)


@app.command("dpoint-table")
def dpoint_table_command(
    recording: Annotated[Path, typer.Argument(help="The D-POINT folder.")],
    output: Annotated[Path, typer.Option(help="Folder for the cells, to resume from.")] = Path(
        "results/dpoint"
    ),
    pen: PenOption = "dpoint",
    rates: Annotated[str, typer.Option(help="Camera rates, Hz.")] = "30,10,3",
    estimators: Annotated[str, typer.Option(help="Names with commas.")] = "ekf,mhe-ipopt",
    horizon: Annotated[int, typer.Option(help="Intervals in the window of an MHE.")] = MHE.horizon,
    duration: Annotated[float | None, typer.Option(help="Use only the first seconds.")] = None,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
) -> None:
    """Mean ink distance over camera rates and all phases, zero delay."""
    with one_sentence():
        dpoint_table.run_table(
            recording,
            output,
            pen,
            [_rate(rate) for rate in rates.split(",")],
            [name.strip() for name in estimators.split(",")],
            horizon,
            duration,
            jobs,
        )


def _rate(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"camera rate {text!r} is not a number, expected Hz") from None


def _names(sensors: str | None) -> tuple[str, ...] | None:
    if sensors is None:
        return None
    return tuple(name.strip() for name in sensors.split(",") if name.strip())


def _units(units: str | None) -> dict[str, str]:
    pairs = [pair.split("=") for pair in units.split(",")] if units else []
    if any(len(pair) != 2 for pair in pairs):
        raise InputError(f"units {units!r}, expected e.g. accel=g,gyro=deg_s")
    return {sensor.strip(): unit.strip() for sensor, unit in pairs}


if __name__ == "__main__":
    app()
