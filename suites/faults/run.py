"""A task of the suite: a fault, or a fault-free stream, on one contender."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Outcome, Quantity, Series, Task, failed
from estimation.status import UNSOLVED
from models.arrays import Array
from suites.faults.clean import CLEAN, LONG_S, SHORT_S, run_clean
from suites.faults.contenders import CONTENDERS, without_watch
from suites.faults.protocol import TIP
from suites.faults.quantities import fault_quantities
from suites.faults.real import REAL, run_real
from suites.faults.said import Said
from suites.faults.scoring import RunErrors
from suites.faults.table import fault_named

SHOWN: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(
        (
            *("hole, all, 10 s", "unit, accel, g, 1 s"),
            *("bias step, gyro, 5 deg/s, to the end", "flipped, gyro, y all along"),
        ),
        "elevation_rad",
    )
)
"""Fault → angle whose error figures show over time."""
SHOWN_SENSORS, SHOWN_ESTIMATORS = "accel+gyro+camera", ("ekf", without_watch("ekf"))
ERROR = "elevation error"


def run_fault(task: Task) -> Outcome:
    """Run a task with a fault."""
    fault, bench = fault_named(task.case), CONTENDERS[task.estimator].bench(task.sensors)
    score, errors = bench.scored(fault, task.seed)
    found = fault_quantities(fault, score, TIP[0] in bench.judged)
    if errors is None:
        nan = float("nan")
        return Outcome(bench.model.name, tuple(found), 0, 0.0, nan, nan, reason=score.broke)
    is_shown = (
        task.seed == 0
        and task.case in SHOWN
        and task.sensors == SHOWN_SENSORS
        and task.estimator in SHOWN_ESTIMATORS
    )
    series = (_series(errors, SHOWN[task.case]),) if is_shown else ()
    return _outcome(
        bench.model.name, found, errors.told, errors.step_time_s, said=score.said, series=series
    )


def run_stream(task: Task, is_long: bool) -> Outcome:
    """Run a fault-free task."""
    bench = CONTENDERS[task.estimator].bench(task.sensors)
    duration_s = LONG_S if is_long else SHORT_S
    found, told, step_time_s = run_clean(bench, task.case, task.seed, duration_s)
    return _outcome(bench.model.name, found, told, step_time_s)


def run_recording(task: Task, data: str | None) -> Outcome:
    """Run a task on a real recording."""
    assert data is not None
    model, found, told, history = run_real(task, data)
    everything = told.words(np.diff(history.time_s, append=history.time_s[-1]))
    return _outcome(model, found, told, history.step_time_s, said=everything)


def run_task(task: Task, data: str | None, is_long: bool) -> Outcome:
    """Run one task.

    Parameters
    ----------
    data : folder of recordings
    is_long : whether fault-free streams have their full length
    """
    if task.estimator not in CONTENDERS:
        return failed(f"{task.estimator} is no contender of the suite")
    if task.case in REAL:
        return run_recording(task, data)
    return run_stream(task, is_long) if task.case in CLEAN else run_fault(task)


def _outcome(
    model: str,
    found: list[Quantity],
    told: Said,
    step_time_s: Array,
    said: str = "",
    series: tuple[Series, ...] = (),
) -> Outcome:
    return Outcome(
        model,
        tuple(found),
        len(step_time_s),
        float(((told.status & UNSOLVED.value) == 0).mean()),
        float(np.median(step_time_s)),
        float(np.quantile(step_time_s, 0.99)),
        reason=said,
        series=series,
    )


def _series(errors: RunErrors, name: str) -> Series:
    i = errors.names.index(name)
    error = np.degrees(errors.errors[:, i])
    claimed = np.abs(error) / errors.stds[:, i]
    return Series(ERROR, "deg", errors.time_s, error, claimed)
