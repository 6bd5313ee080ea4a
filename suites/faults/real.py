"""The real pen, on which nothing is broken: what a watch says of it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from benchmark.configurations import CONFIGURATIONS
from benchmark.tasks.task import Quantity
from estimation.estimator import Estimator, run
from estimation.history import EstimateHistory
from estimation.recording import Recording
from models.pen import pen_model
from models.pen_file import load_pen
from pen_mhe.estimators import create_estimator
from recordings.formats.dpoint import load_dpoint
from suites.faults.clean import flags_raised
from suites.faults.contenders import CONTENDERS
from suites.faults.quantities import REAL_FLAGS
from suites.faults.said import Said

PEN, FOLDER, CASE = "dpoint", "dpoint_pen", "D-POINT"
SENSORS = ("accel+gyro", "accel+gyro+camera")


def has_recording(data: str | None) -> bool:
    """Whether a folder of recordings has this one."""
    return data is not None and (Path(data) / FOLDER).is_dir()


def run_real(
    estimator: str, sensors: str, data: str
) -> tuple[str, list[Quantity], Said, EstimateHistory]:
    """Return what a contender finds: its model, how many flags, what was said, the history."""
    of = _estimator(estimator, sensors)
    history = run(of, _recording(data).select(CONFIGURATIONS[sensors].sensors))
    told = Said.of(history)
    return of.model.name, [Quantity.single(REAL_FLAGS, "1", flags_raised(told))], told, history


@cache
def _recording(data: str) -> Recording:
    return load_dpoint(Path(data) / FOLDER, load_pen(PEN)).recording


@cache
def _estimator(name: str, sensors: str) -> Estimator[Any]:
    contender = CONTENDERS[name]
    model = pen_model(load_pen(PEN), CONFIGURATIONS[sensors].sensors)
    return contender.wrap(create_estimator(contender.estimator, model))
