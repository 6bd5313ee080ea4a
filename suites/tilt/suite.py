"""The suite ``tilt``: [Tilt], and estimators with a model on the same samples."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Quantity, Task
from classical_baseline.weight_search import CURVE_WEIGHTS, best_weight, weight_curve
from models.errors import InputError
from suites.tilt.cases import CASES, CURVE_CASES, FULL_TURN
from suites.tilt.estimators import (
    ACCELEROMETER,
    CURVE,
    FIXED_WEIGHT,
    MODEL_BASED,
    TiltRun,
    run_accelerometer,
    run_fixed_weight,
    run_model,
)
from suites.tilt.figures import SHOWN, curve_quantity, figures
from suites.tilt.samples import TiltSamples, case_named, simulate_samples
from suites.tilt.scores import angle_series, scores
from suites.tilt.weights import weight_rmse_deg

NAME = "tilt"
BOTH, ACCEL = "accel+gyro", "accel"
ESTIMATORS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(MODEL_BASED, BOTH),
        CURVE: BOTH,
        **dict.fromkeys(FIXED_WEIGHT, BOTH),
        ACCELEROMETER: ACCEL,
    }
)
"""Estimator → its sensors; the slow ones first."""

EXCEPT: Mapping[str, Collection[str]] = MappingProxyType(
    {
        CURVE: frozenset(CASES) - frozenset(CURVE_CASES),
        "fixed-weight-carried": {FULL_TURN},  # there it is at home
    }
)
"""Estimator → cases in which it does not run."""


def tasks(scope: Scope) -> Sequence[Task]:
    """Return all tasks, those of the slowest estimator first."""
    return [
        Task(NAME, case, sensors, estimator, seed)
        for estimator, sensors in ESTIMATORS.items()
        for case in CASES
        if case not in EXCEPT.get(estimator, ())
        for seed in range(scope.seeds)
    ]


def run(task: Task, scope: Scope) -> Outcome:
    """Run one task.

    Raises
    ------
    InputError
        If its estimator does not run with its sensors.
    """
    case_named(task.case)
    if ESTIMATORS.get(task.estimator) != task.sensors:
        raise InputError(
            f"estimator {task.estimator} with sensors {task.sensors} is unknown, expected one of "
            + ", ".join(f"{name} with {sensors}" for name, sensors in ESTIMATORS.items())
        )
    samples = _samples(task.case, task.seed)
    if task.estimator == CURVE:
        return _curve(task.case, samples)
    found = _run_of(task.estimator)(task, samples)
    shown = task.seed == 0 and task.estimator in SHOWN.get(task.case, ())
    return Outcome(
        found.model,
        (*scores(samples, found.direction), *found.figures),
        len(samples.time_s),
        found.solved_fraction,
        float(np.median(found.step_time_s)),
        float(np.quantile(found.step_time_s, 0.99)),
        series=angle_series(samples, found.direction, found.roll_std_deg) if shown else (),
    )


def _run_of(estimator: str) -> Callable[[Task, TiltSamples], TiltRun]:
    if estimator in FIXED_WEIGHT:
        return lambda task, samples: run_fixed_weight(task.estimator, task.case, samples)
    if estimator in MODEL_BASED:
        return lambda task, samples: run_model(task.estimator, task.case, samples)
    return lambda task, samples: run_accelerometer(samples)


def _curve(case: str, samples: TiltSamples) -> Outcome:
    """Return the error for every weight of the curve, and the best of these weights."""

    def rmse(weight: float) -> float:
        return weight_rmse_deg(case, samples, weight)

    nan, curve = float("nan"), weight_curve(rmse)
    found = [
        Quantity(curve_quantity(case, weight), "deg", error, nan, nan)
        for weight, error in zip(CURVE_WEIGHTS, curve.tolist(), strict=True)
    ]
    found.append(Quantity.single("weight", "1", best_weight(CURVE_WEIGHTS, curve)))
    return Outcome("", tuple(found), len(samples.time_s), 1.0, nan, nan)


@lru_cache(maxsize=64)
def _samples(case: str, seed: int) -> TiltSamples:
    return simulate_samples(case_named(case), seed)


SUITE = Suite(
    name=NAME,
    title="Tilt by fixed weights [Tilt]",
    summary=(
        "[Tilt] fuses an accelerometer and a gyroscope with one fixed weight w, finds w by "
        "bisection over [0, 1], turns a carrier once around with w = 0.25 and sets the result "
        "against a Kalman filter. The equations that weigh are lost: w may be that of R_acc + w "
        "R_g or of (1 - w) R_acc + w R_g, and what depends on it is judged for both. Here a "
        "simulated carrier is read through the paper's converter (16 bit, 5 V, 478.5 mV/g); "
        "noise and motion are ours, as the paper's are lost. The weights are searched over ten "
        "recordings that are not judged, within [0, 1] as published and up to 300. EKF and MHE "
        "get the same samples with the model of a table that tilts about two axes. Operations "
        "are instructions of CasADi functions for all, and all times are those of machine code."
    ),
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=figures,
    row=lambda task: task.case,
)
