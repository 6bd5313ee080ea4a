"""Tasks on simulated gestures."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmark.from_mhe import NEAR, REFERENCE, distance_quantity
from benchmark.tasks.task import Outcome, Quantity, Series, Task
from estimation.recording import Recording
from models.arrays import Array
from suites.gyro_free.cases import (
    CASES,
    CLASSICAL,
    CONFIGURATIONS,
    NO_ROLL,
    NO_SPIN,
    TEST_CASE,
    TWO_ACCELS,
    GyroFreeCase,
)
from suites.gyro_free.classical import classical_gesture
from suites.gyro_free.from_start import run_from
from suites.gyro_free.gesture import GestureMotion, gesture
from suites.gyro_free.pen import (
    LOWER,
    NO_ROLL_SENSOR,
    UPPER,
    TwoAccelerometers,
    rates_and_cosines,
    start,
    two_accelerometers,
)
from suites.gyro_free.readings import readings
from suites.gyro_free.scores import Estimated, path_series, rate_series, scores

LEAST_NOISE_FACTOR = 0.1
"""What an estimator is told of readings without noise."""

SHOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        TWO_ACCELS: ("gyro-free-integrated", "gyro-free", "gyro-free-backward"),
        NO_ROLL: ("ekf", "mhe"),
        NO_SPIN: (),
    }
)
"""Sensors → estimators of which there are series."""

PATH_SHOWN = ("gyro-free-integrated", "gyro-free", "ekf", "mhe")


def run_simulated(task: Task) -> Outcome:
    """Run a task on a gesture."""
    case = CASES[task.case]
    motion = gesture(case.gesture, task.seed)
    f1, f2 = readings(motion, case.half_distance_m, case.reading_errors, task.seed)
    if case.first_s is not None:
        motion = motion.first(case.first_s)
        f1, f2 = f1[: len(motion.time_s)], f2[: len(motion.time_s)]
    if task.estimator in CLASSICAL:
        estimated, figures, step_s = classical_gesture(
            task.estimator, motion, f1, f2, case.half_distance_m
        )
        name, solved, sees_roll = "", 1.0, False
    else:
        name, estimated, solved, step_s, figures = _model_based(task, case, motion, f1, f2)
        sees_roll = not CONFIGURATIONS[task.sensors].no_roll
    return Outcome(
        name,
        (*scores(motion, estimated, sees_roll), *figures),
        len(motion.time_s),
        solved,
        float(np.median(step_s)),
        float(np.quantile(step_s, 0.99)),
        series=_series(task, motion, estimated),
    )


def _model_based(
    task: Task, case: GyroFreeCase, motion: GestureMotion, f1: Array, f2: Array
) -> tuple[str, Estimated, float, Array, tuple[Quantity, ...]]:
    configuration, errors = CONFIGURATIONS[task.sensors], case.reading_errors
    least = LEAST_NOISE_FACTOR * case.errors.single_noise_std
    pen = TwoAccelerometers(
        case.half_distance_m,
        max(errors.single_noise_std, least),
        errors.single_bias_std,
        configuration.degrees_of_freedom,
        configuration.no_roll,
    )
    _, model = two_accelerometers(pen)
    given = {LOWER: f1, UPPER: f2}
    if configuration.no_roll:
        given[NO_ROLL_SENSOR] = np.zeros((len(motion.time_s), 1))
    recording = Recording(task.case, motion.time_s, given)
    prior, is_reference = start(model, motion.C[0]), task.estimator == REFERENCE
    history = run_from(task.estimator, pen, prior, recording, covariances=is_reference)
    figures: tuple[Quantity, ...] = ()
    if is_reference:
        near = run_from(NEAR, pen, prior, recording)
        figures = (distance_quantity(model, history, near),)
    rate, C = rates_and_cosines(history.mean, configuration.degrees_of_freedom)
    estimated = Estimated(rate, C, history.mean[:, :3])
    return model.name, estimated, history.solved_fraction, history.step_time_s, figures


def _series(task: Task, motion: GestureMotion, estimated: Estimated) -> tuple[Series, ...]:
    """Return what the figures of the test case show."""
    if task.case != TEST_CASE or task.seed != 0 or task.estimator not in SHOWN[task.sensors]:
        return ()
    rates = rate_series(motion.time_s, estimated.rate, motion.rate)
    paths = path_series(motion, estimated.position) if task.estimator in PATH_SHOWN else ()
    return (*rates, *paths)
