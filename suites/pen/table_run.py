"""A run on the turntable: a stroke, or a start that is wrong."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmark.configurations import BENCHMARK_ESTIMATORS, TURNTABLE_CONFIGURATIONS
from benchmark.from_mhe import NEAR, REFERENCE, distance_quantity
from benchmark.tasks.history import outcome, state_series
from benchmark.tasks.task import OK, Outcome, Quantity, Task
from estimation.estimator import Estimator, run
from estimation.observability import Verdict
from models.arrays import Array
from models.priors import replaced_prior
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from models.table_motion import table_motions
from models.turntable import TILTS, turntable_model
from pen_mhe.errors import state_errors
from pen_mhe.estimators import create_estimator
from pen_mhe.sensor_verdict import judge
from suites.pen.raw_readings import RAW_SHOWN, raw_series
from suites.pen.table_recordings import start_recording, stroke_recording
from suites.pen.told_tolerance import SHOWN, SWEEP, ToldStroke, told_table
from suites.pen.turntable_starts import StartTrial, run_start

TABLE_ESTIMATORS = (*BENCHMARK_ESTIMATORS, "mhe-sparse")
STROKES = tuple(table_motions())
START_STD_RAD = math.radians(2.0)
"""How well the start of a stroke is known; the error is drawn from it."""

START_ERRORS_DEG = (0, 10, 20, 30, 45, 60)
STARTS: Mapping[str, float] = MappingProxyType(
    {f"start {error} deg": math.radians(error) for error in START_ERRORS_DEG}
)
"""Case → error of the start, in φ and in θ."""

STEP_S = 0.01
SETTLED_RAD, SETTLED_S = math.radians(2.0), 0.5
"""Settled: both tilts are this near, for this long."""

WITH_IPOPT_S = 3.0
WITH_IPOPT = f"turntable, horizontal-turn-vertical, {WITH_IPOPT_S:g} s"
"""The begin of the first stroke of `SHOWN`, which IPOPT solves too."""

DEG = 180 / math.pi


@dataclass(frozen=True)
class Settling:
    """What parts of a run are judged, s.

    Parameters
    ----------
    skipped_s : begin that most errors leave out
    corner_s : how long after a corner a sample belongs to it
    """

    skipped_s: float = 1.0
    corner_s: float = 0.5


PARTS = Settling()


def run_stroke(task: Task) -> Outcome:
    """Run an estimator along a stroke from a start known to `START_STD_RAD`."""
    is_begin = task.case == WITH_IPOPT
    told_stroke = ToldStroke(SHOWN[0]) if is_begin else SWEEP.get(task.case, ToldStroke(task.case))
    motion = table_motions()[told_stroke.stroke]
    estimator = _estimator(task.sensors, task.estimator, told_stroke.reached_after_s)
    model = estimator.model
    recording = stroke_recording(told_stroke.stroke, task.seed)
    if is_begin:
        recording = recording.first(WITH_IPOPT_S)
    truth = recording.truth
    assert truth is not None
    drawn = stream(seed_sequence(task.seed), "error of the start").standard_normal(2)
    start = truth.values[0, :2] + START_STD_RAD * drawn
    told = replaced_prior(
        model, dict(zip(model.state_names[:2], start, strict=True)), START_STD_RAD
    )
    sensors = [sensor.name for sensor in model.measured_sensors]
    blind = replace(recording.select(sensors), truth=None)
    is_reference = task.estimator == REFERENCE
    history = run(estimator, blind, prior=told, covariances=is_reference)
    errors = state_errors(model, history, truth)[:, :4]
    rates = truth.states(model.state_names[2:4], history.time_s)
    quantities = stroke_quantities(
        history.time_s, errors, rates, motion.corners_s, _verdict(told_stroke.stroke, task.sensors)
    )
    if is_reference:
        near = run(_estimator(task.sensors, NEAR), blind, prior=told)
        quantities.append(distance_quantity(model, history, near))
    series = []
    if task.seed == 0 and task.case in SHOWN:
        series = [
            state_series(history, truth, f"{tilt}{state}", f"{tilt}{quantity}", unit, DEG)
            for tilt in TILTS
            for state, quantity, unit in (("_rad", "", "deg"), ("_rate_rad_s", "_rate", "deg/s"))
        ]
        if (task.sensors, task.estimator) == RAW_SHOWN:
            series += raw_series(recording)
    return outcome(model.name, history, quantities, series=series)


def stroke_quantities(
    time_s: Array, errors: Array, rates: Array, corners_s: Array, seen: Mapping[str, bool]
) -> list[Quantity]:
    """Return what is judged of a run on the table.

    Parameters
    ----------
    time_s : (n,)
    errors : (n, 4) of (φ, θ, φ̇, θ̇), rad and rad/s
    rates : (n, 2) true ones
    corners_s : instants at which an axis starts, stops or turns
    seen : state name → whether the sensors show it
    """
    tilts, tilt_rates = DEG * errors[:, :2], DEG * errors[:, 2:4]
    later = time_s - time_s[0] >= PARTS.skipped_s
    corner = later & near_corner(time_s, corners_s)
    straight = later & ~corner
    angles, rates_seen = _both_seen(seen)
    found = [
        Quantity.of_errors(f"{tilt}{name}", unit, of[later, i], seen[f"{tilt}{state}"])
        for i, tilt in enumerate(TILTS)
        for name, unit, of, state in (
            ("", "deg", tilts, "_rad"),
            ("_rate", "deg/s", tilt_rates, "_rate_rad_s"),
        )
    ]
    parts: tuple[tuple[str, NDArray[np.bool_]], ...] = (
        ("", later),
        ("_corner", corner),
        ("_straight", straight),
        ("_last", time_s >= time_s[-1] - 1.0),
    )
    for name, part in parts:
        if part.any():
            found.append(Quantity.of_errors(f"tilts{name}", "deg", tilts[part], angles))
            found.append(
                Quantity.of_errors(f"tilt_rates{name}", "deg/s", tilt_rates[part], rates_seen)
            )
    size = np.sqrt(np.mean((DEG * rates[later]) ** 2) * 2)
    if size > 0:
        relative = np.sqrt(np.mean(tilt_rates[later] ** 2) * 2) / size
        found.append(Quantity.single("tilt_rates_relative", "1", float(relative), rates_seen))
    found.append(Quantity.single("settling", "s", settling_time(time_s, errors[:, :2]), angles))
    changes = np.diff(tilts, axis=0)
    found.append(Quantity.of_errors("jitter", "deg", changes))
    off_corners = straight[1:] & straight[:-1]
    if off_corners.any():
        found.append(Quantity.of_errors("jitter_straight", "deg", changes[off_corners]))
    slopes = np.polynomial.polynomial.polyfit(time_s, tilts, 1)[1]
    found.append(Quantity.single("drift", "deg/s", float(np.linalg.norm(slopes))))
    return found


def _both_seen(seen: Mapping[str, bool]) -> tuple[bool, bool]:
    """Return whether the sensors show both tilts, and both of their rates."""
    return all(seen[f"{t}_rad"] for t in TILTS), all(seen[f"{t}_rate_rad_s"] for t in TILTS)


def near_corner(time_s: Array, corners_s: Array) -> NDArray[np.bool_]:
    """Return which instants (n,) are within `Settling.corner_s` after a corner."""
    since = time_s[:, None] - np.asarray(corners_s)[None, :]
    within: NDArray[np.bool_] = (since >= 0) & (since < PARTS.corner_s)
    return np.asarray(within.any(axis=1))


def settling_time(time_s: Array, tilt_errors: Array) -> float:
    """Return when both tilts first are within `SETTLED_RAD` for `SETTLED_S`; infinite if never.

    Parameters
    ----------
    tilt_errors : (n, 2) rad
    """
    within = (np.abs(tilt_errors) <= SETTLED_RAD).all(axis=1)
    outside_s = time_s[~within]
    for time in time_s[within]:
        following = outside_s[outside_s > time]
        if len(following) == 0 or following[0] - time > SETTLED_S:
            return float(time - time_s[0]) if time_s[-1] - time >= SETTLED_S else math.inf
    return math.inf


def run_wrong_start(task: Task) -> Outcome:
    """Run an estimator from a start that is wrong in both tilts; both axes run."""
    trial = StartTrial(task.sensors, task.estimator, STARTS[task.case])
    estimator = _estimator(task.sensors, task.estimator)
    found = run_start(trial, task.seed, estimator=estimator, recording=start_recording(task.seed))
    in_mirror = found.outcome == "mirror"
    last = DEG * found.error[found.judged]
    settled_s = settling_time(found.time_s, found.error[:, :2])
    angles, rates_seen = _both_seen(_verdict(None, task.sensors))
    quantities = [
        Quantity.of_errors("tilts_last", "deg", last[:, :2], angles),
        Quantity.of_errors("tilt_rates_last", "deg/s", last[:, 2:4], rates_seen),
        Quantity.single("settling", "s", settled_s, angles),
    ]
    return Outcome(
        turntable_model(trial.table).name,
        tuple(quantities),
        len(found.time_s),
        found.solved_fraction,
        float(np.median(found.step_time_s)),
        float(np.quantile(found.step_time_s, 0.99)),
        "mirror" if in_mirror else OK,
        "settled in the mirror solution, which the sensors cannot tell from the truth"
        if in_mirror
        else "",
    )


@cache
def _estimator(sensors: str, name: str, reached_after_s: float | None = None) -> Estimator[Any]:
    return create_estimator(name, _model(sensors, reached_after_s))


@cache
def _model(sensors: str, reached_after_s: float | None) -> StateSpaceModel:
    """Return the model that estimators of a configuration share, with what is derived of it."""
    return turntable_model(told_table(reached_after_s), TURNTABLE_CONFIGURATIONS[sensors].sensors)


@cache
def _verdict(stroke: str | None, sensors: str) -> Mapping[str, bool]:
    """Return which states a configuration shows along a stroke, or None: both axes running."""
    model = _model(sensors, None)
    recording = start_recording(0) if stroke is None else stroke_recording(stroke, 0)
    found: Verdict = judge(model, recording)
    return MappingProxyType({name: found.sees(name) for name in model.state_names})
