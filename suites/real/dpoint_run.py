"""A run on the D-POINT recording: some sensors, a camera of some rate, one phase of its frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.tasks.history import outcome
from benchmark.tasks.task import Outcome, Quantity, Series, Task
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.recording import Recording
from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from pen_mhe.causal_run import causal_lags
from pen_mhe.estimators import create_estimator
from recordings.formats.dpoint import load_dpoint
from recordings.ink import ink_match
from recordings.thinning import CameraThinning, left_out_error, thinned
from recordings.written import WrittenRecording
from suites.real.cases import (
    CASES,
    HORIZON,
    LAG,
    NO_CAMERA,
    UNBIASED,
    WITH_CAMERA,
    WITHOUT_CAMERA,
    RealCase,
)
from suites.real.elevation import elevation_quantities, elevation_series
from suites.real.ingredients import INGREDIENTS, without_bias, without_level

PEN, FOLDER = "dpoint", "dpoint_pen"
CLOCK = "accel"
"""The sensor at whose instants the tip's path is judged."""

DEG = 180 / math.pi
SHOWN_S = 8.0
"""Length of the series that a figure shows."""

LEFT_OUT = (("left_out_position", "m", "mm", 1e3), ("left_out_orientation", "rad", "deg", DEG))
"""Quantity, unit of the residual's rows, unit shown, factor."""

VARIANTS: Mapping[str, Callable[[PenConfig], PenConfig]] = MappingProxyType(
    {
        "": lambda pen: pen,
        **INGREDIENTS,
        NO_CAMERA: without_level,
        UNBIASED: lambda pen: without_bias(without_level(pen)),
    }
)
"""Name → the pen that an estimator assumes, of that of the file.

Without a camera nothing sees the paper, so its level means nothing, and a bias of the accelerometer
and a tilt of the pen are nearly the same to every reading; `UNBIASED` tells that there is none.
"""


def run_dpoint(task: Task, data: str, *, looks_back: bool = False) -> Outcome:
    """Run an estimator on the recording.

    Parameters
    ----------
    task : its seed is the phase of the thinning, or chooses when the camera looks away
    data : folder that holds `FOLDER`
    looks_back : whether to judge what is told `LAG` samples later, too
    """
    written = _recording(data)
    if task.case in CASES:
        return _with_camera(task, written, CASES[task.case], looks_back)
    pen, whole = load_pen(PEN), written.recording
    estimator = _estimator(variant(task.case), task.sensors, task.estimator)
    history = run(estimator, whole.select(WITHOUT_CAMERA[task.sensors]))
    found = elevation_quantities(pen, history, whole)
    series = elevation_series(pen, history, whole)
    return outcome(estimator.model.name, history, found, series=series)


def _with_camera(
    task: Task, written: WrittenRecording, case: RealCase, looks_back: bool
) -> Outcome:
    whole, model = written.recording, _model(case.without, task.sensors)
    instants = _with_clock(whole, WITH_CAMERA[task.sensors])
    phase = 0 if case.away_s else task.seed
    used = thinned(model, instants, CameraThinning(case.rate_hz, phase))
    if case.away_s:
        used, instants = _looking_away(used, case.away_s, task.seed)
    settings = {"horizon": HORIZON, "lag_samples": LAG} if looks_back else {}
    lag, settings = causal_lags(
        task.estimator, settings, used.select(WITH_CAMERA[task.sensors]), CLOCK
    )
    history = run(
        _estimator(case.without, task.sensors, task.estimator, tuple(settings.items())),
        used,
        causal=case.causal,
    )
    clock = used.sensor("clock")[0]
    found = [] if case.away_s else _ink("ink", written, history.at(clock))
    if lag:
        found += _ink(f"ink_{lag}", written, history.at_lag_of(lag, clock))
    left_out = left_out_error(model, model.sensor("camera"), history, instants, used)
    if left_out is not None:
        for quantity, unit, shown, factor in LEFT_OUT:
            found.append(Quantity.single(quantity, shown, factor * left_out.rms[unit]))
    series = _paths(history.at(clock)) if task.seed == 0 else ()
    return outcome(model.name, history, found, series=series)


def _with_clock(whole: Recording, sensors: Sequence[str]) -> Recording:
    """Return a recording of some sensors that has the clock's instants, used or not."""
    times, ticks = whole.sensor(CLOCK)
    chosen = {name: whole.sensor(name) for name in sensors}
    return Recording.from_sensors(whole.name, chosen | {"clock": (times, np.zeros_like(ticks))})


def _looking_away(recorded: Recording, away_s: float, seed: int) -> tuple[Recording, Recording]:
    """Return a recording whose camera looks away once, and one with no frames but those."""
    times, frames = recorded.sensor("camera")
    rng = stream(seed_sequence(seed), "when the camera looks away")
    start = rng.uniform(times[0] + 1, times[-1] - away_s - 1)
    away = (times >= start) & (times < start + away_s)
    parts = {name: recorded.sensor(name) for name in recorded.readings if name != "camera"}
    seen, unseen = (
        Recording.from_sensors(recorded.name, {**parts, "camera": (times[at], frames[at])})
        for at in (~away, away)
    )
    return seen, unseen


def _ink(name: str, written: WrittenRecording, output: EstimateHistory) -> list[Quantity]:
    """Return the mean ink distance, and that of either half of the path."""
    match = None if written.ink is None else ink_match(output, written.ink)
    if match is None:
        return []
    found = [Quantity.single(name, "mm", match.mean_distance_mm)]
    if math.isinf(match.mean_distance_mm):
        return found
    middle = len(match.distance_mm) // 2
    halves = {"first": match.distance_mm[:middle], "second": match.distance_mm[middle:]}
    return found + [
        Quantity.single(f"{name}, {half} half", "mm", float(distance.mean()))
        for half, distance in halves.items()
    ]


def _paths(output: EstimateHistory) -> tuple[Series, ...]:
    shown = output.time_s <= output.time_s[0] + SHOWN_S
    return tuple(
        Series(
            f"tip_{axis}", "mm", output.time_s[shown], 1e3 * output.column(f"tip_{axis}_m")[shown]
        )
        for axis in "xy"
    )


@cache
def _recording(data: str) -> WrittenRecording:
    folder = Path(data) / FOLDER
    if not folder.is_dir():
        raise InputError(f"data folder {data} has no {FOLDER}, expected it there")
    return load_dpoint(folder, load_pen(PEN))


def variant(case: str) -> str:
    """Return the name of the pen in `VARIANTS` that the estimators of a case assume."""
    return CASES[case].without if case in CASES else case


@cache
def _estimator(
    assumed: str, sensors: str, name: str, settings: tuple[tuple[str, Any], ...] = ()
) -> Estimator[Any]:
    return create_estimator(name, _model(assumed, sensors), **dict(settings))


@cache
def _model(assumed: str, sensors: str) -> StateSpaceModel:
    """Return the model that estimators of a configuration share, with what is derived of it."""
    return pen_model(VARIANTS[assumed](load_pen(PEN)), {**WITH_CAMERA, **WITHOUT_CAMERA}[sensors])
