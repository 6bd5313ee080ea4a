"""The published way from two accelerometers to a path, timed."""

from __future__ import annotations

import time

import numpy as np

from benchmark.tasks.task import Quantity
from classical_baseline.attitude import direction_cosines
from classical_baseline.differential import (
    angular_acceleration_without_roll,
    centre_specific_force,
    differential_solution,
)
from classical_baseline.gesture import gesture_path
from classical_baseline.gyro_free import GyroFreeRate, integrate_rate
from classical_baseline.sampling import even_step
from models.arrays import Array
from suites.gyro_free.cases import CLASSICAL
from suites.gyro_free.gesture import GestureMotion
from suites.gyro_free.readings import GRAVITY_M_S2
from suites.gyro_free.scores import Estimated, growth

TIMED_RUNS = 2


def classical_rate(
    estimator: str,
    time_s: Array,
    f1: Array,
    f2: Array,
    half_distance_m: float,
    start: Array | None = None,
) -> GyroFreeRate:
    """Return the rate that one of `CLASSICAL` finds; start (3,) rad/s, at rest by default."""
    c = differential_solution(f1, f2, half_distance_m)
    first = (0.0, 0.0) if start is None else (float(start[1]), float(start[2]))
    return integrate_rate(c, even_step(time_s), first, CLASSICAL[estimator])


def classical_gesture(
    estimator: str, motion: GestureMotion, f1: Array, f2: Array, half_distance_m: float
) -> tuple[Estimated, tuple[Quantity, ...], Array]:
    """Return estimate, figures of its own, and times per sample (runs,) in s.

    The start is known: at rest, in the motion's first attitude.

    The figures: ``compensated`` samples; errors of the ``angular acceleration`` by the
    differential solution, and their growth.
    """
    step_s, seconds = even_step(motion.time_s), []
    for _ in range(TIMED_RUNS):
        begin = time.perf_counter()
        rate = classical_rate(estimator, motion.time_s, f1, f2, half_distance_m)
        C = direction_cosines(rate.rate, step_s, motion.C[0])
        path = gesture_path(C, centre_specific_force(f1, f2), step_s, GRAVITY_M_S2)
        seconds.append((time.perf_counter() - begin) / len(motion.time_s))
    c = differential_solution(f1, f2, half_distance_m)
    error = np.degrees(angular_acceleration_without_roll(c) - motion.rate_derivative)
    figures = (
        Quantity.single("compensated", "%", 100 * float(rate.compensated.mean())),
        Quantity.of_errors("angular acceleration", "deg/s²", error),
        Quantity.single("angular acceleration growth", "1", growth(error)),
    )
    return Estimated(rate.rate, C, path.position), figures, np.array(seconds)
