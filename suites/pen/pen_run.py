"""A run of the whole pen at handwriting speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, lru_cache
from types import MappingProxyType
from typing import Any

from benchmark.configurations import CONFIGURATIONS
from benchmark.from_mhe import NEAR, distance_quantity
from benchmark.from_mhe import REFERENCE as OPTIMUM
from benchmark.tasks.history import outcome, state_series
from benchmark.tasks.task import Outcome, Series, Task
from estimation.estimator import Estimator, run
from estimation.outputs import outputs_of
from estimation.recording import Recording
from models.pen import pen_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from pen_mhe.sensor_verdict import judge
from recordings.simulate_pen import simulate
from suites.pen.pen_cases import (
    MOTION,
    PEN_CASES,
    REFERENCE,
    SPIN_IGNORED,
    moving_pen,
)
from suites.pen.told_pens import ToldPen, told_pen
from suites.pen_quantities import pen_quantities

SHOWN: Mapping[str, tuple[str, str, float]] = MappingProxyType(
    {
        "tip_x": ("tip_x_m", "mm", 1e3),
        "tip_y": ("tip_y_m", "mm", 1e3),
        "elevation": ("elevation_rad", "deg", 180 / math.pi),
    }
)
"""Quantity of a series → output, unit, factor from SI."""

SHOWN_SENSORS: Mapping[str, Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        REFERENCE: {
            "gyro": ("elevation",),
            "accel+gyro": ("elevation",),
            "camera": ("tip_x", "tip_y", "elevation"),
            "accel+gyro+camera": ("tip_x", "tip_y", "elevation"),
        },
        SPIN_IGNORED: {"gyro": ("elevation",), "accel+gyro": ("elevation",)},
    }
)
"""Case → configuration → quantities that figures show over time."""


def run_pen(task: Task) -> Outcome:
    """Run an estimator on simulated handwriting."""
    row = PEN_CASES[task.case]
    estimator = _estimator(row.assumed, task.sensors, task.estimator)
    recording = _recording(task.case, task.sensors, task.seed)
    truth = recording.truth
    assert truth is not None
    model = estimator.model
    blind, is_reference = replace(recording, truth=None), task.estimator == OPTIMUM
    history = run(estimator, blind, covariances=is_reference)
    seen = _seen(task.case, task.sensors)
    quantities = pen_quantities(model, history, truth, seen, settling_s=row.settling_s)
    if is_reference:
        near = run(_estimator(row.assumed, task.sensors, NEAR), blind)
        quantities.append(distance_quantity(model, history, near))
    series: list[Series] = []
    if task.seed == 0:
        series = [
            state_series(history, truth, SHOWN[name][0], name, *SHOWN[name][1:])
            for name in SHOWN_SENSORS.get(task.case, {}).get(task.sensors, ())
        ]
    return outcome(model.name, history, quantities, series=series)


@lru_cache(maxsize=32)
def _recording(case: str, sensors: str, seed: int) -> Recording:
    return simulate(
        moving_pen(case),
        CONFIGURATIONS[sensors].sensors,
        motion=MOTION,
        duration_s=PEN_CASES[case].duration_s,
        seed=seed,
        speed=PEN_CASES[case].assumed.speed,
    )


@cache
def _estimator(assumed: ToldPen, sensors: str, name: str) -> Estimator[Any]:
    return create_estimator(name, _model(assumed, sensors))


@cache
def _model(assumed: ToldPen, sensors: str) -> StateSpaceModel:
    """Return the model that estimators of a configuration share, with what is derived of it."""
    return pen_model(told_pen(assumed), CONFIGURATIONS[sensors].sensors)


@cache
def _seen(case: str, sensors: str) -> Mapping[str, bool]:
    """Return which outputs a configuration shows, along the motion of seed 0.

    What the sensors show is the moving pen's matter, not that of what is assumed of it.
    """
    model = pen_model(moving_pen(case), CONFIGURATIONS[sensors].sensors)
    found = judge(model, _recording(case, sensors, 0))
    return MappingProxyType({name: found.sees(name) for name in outputs_of(model).names})
