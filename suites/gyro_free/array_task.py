"""Tasks on the real array: a segment as all pairs of a kind see it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Outcome, Quantity, Task
from estimation.recording import Recording
from models.arrays import Array
from models.motion import white_jerk_motion
from models.pen_config import Prior
from suites.gyro_free.array_pairs import PARTS, PairSegment, load_array, pair_segment
from suites.gyro_free.cases import ARRAY_CASES, CLASSICAL
from suites.gyro_free.classical import classical_rate
from suites.gyro_free.from_start import run_from
from suites.gyro_free.pen import (
    LOWER,
    UPPER,
    TwoAccelerometers,
    rates_and_cosines,
    start,
    two_accelerometers,
)
from suites.gyro_free.scores import rate_series

NOISE_STD_M_S2 = 0.035
BIAS_STD_M_S2 = 0.02
"""Of one accelerometer: the noise of its still moments, and what the calibration may leave."""

TURN_START = Prior(
    tip_std_m=1e-4,
    azimuth_std_rad=0.01,
    elevation_std_rad=0.01,
    spin_std_rad=0.01,
    velocity_std_m_s=0.01,
    angle_rate_std_rad_s=0.02,
    acceleration_std_m_s2=0.1,
    angle_acceleration_std_rad_s2=0.5,
)
TURN_MOTION = white_jerk_motion(tip=20.0, attitude=50.0)
"""A hand that turns a board by a right angle within half a second."""

SHOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "array diagonal": ("gyro-free-integrated", "gyro-free-careful", "ekf", "mhe"),
        "array diagonal, shaken": ("gyro-free-integrated", "gyro-free-careful"),
    }
)
"""Case → estimators of which there are series, of the first pair."""


def run_array(task: Task, data: str) -> Outcome:
    """Run a task on the array."""
    case = ARRAY_CASES[task.case]
    array = load_array(data)
    segment = PARTS[case.part](data)[task.seed]
    seen = [pair_segment(array, segment, pair) for pair in case.pairs]
    sees_roll = task.estimator not in CLASSICAL
    if not sees_roll:
        name, rates, solved, step_s = _classical(task.estimator, seen)
    else:
        name, rates, solved, step_s = _model_based(task.estimator, seen)
    errors = np.concatenate([rate - one.rate for rate, one in zip(rates, seen, strict=True)])
    size = np.concatenate([one.rate for one in seen])[:, 1:]
    by_size = 100 * np.sqrt((errors[:, 1:] ** 2).sum() / (size**2).sum())
    shown = task.seed == 0 and task.estimator in SHOWN.get(task.case, ())
    return Outcome(
        name,
        (
            Quantity.of_errors("rate", "deg/s", np.degrees(errors[:, 1:])),
            Quantity.of_errors("roll rate", "deg/s", np.degrees(errors[:, 0]), sees_roll),
            Quantity.single("rate by size", "%", float(by_size)),
        ),
        len(errors),
        solved,
        float(np.median(step_s)),
        float(np.quantile(step_s, 0.99)),
        series=rate_series(seen[0].time_s, rates[0], seen[0].rate) if shown else (),
    )


def _classical(estimator: str, seen: list[PairSegment]) -> tuple[str, list[Array], float, Array]:
    rates, step_s = [], []
    for one in seen:
        begin = time.perf_counter()
        found = classical_rate(
            estimator, one.time_s, one.f1, one.f2, one.half_distance_m, one.start_rate
        )
        step_s.append((time.perf_counter() - begin) / len(one.time_s))
        rates.append(found.rate)
    return "", rates, 1.0, np.array(step_s)


def _model_based(estimator: str, seen: list[PairSegment]) -> tuple[str, list[Array], float, Array]:
    rates, step_s, solved = [], [], []
    for one in seen:
        # Rounded: distances of equal pairs differ in their last digit, and each is a model.
        pen = TwoAccelerometers(
            round(one.half_distance_m, 9),
            NOISE_STD_M_S2,
            BIAS_STD_M_S2,
            prior=TURN_START,
            motion=TURN_MOTION,
        )
        _, model = two_accelerometers(pen)
        recording = Recording("array", one.time_s, {LOWER: one.f1, UPPER: one.f2})
        history = run_from(estimator, pen, start(model, one.C, one.start_rate), recording)
        rates.append(rates_and_cosines(history.mean, 6)[0])
        step_s.append(history.step_time_s)
        solved.append(history.solved_fraction)
    return model.name, rates, float(np.mean(solved)), np.concatenate(step_s)
