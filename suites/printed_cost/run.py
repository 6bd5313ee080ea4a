"""What the paper's errors cost: one motion at several speeds, each error by itself.

The rigid body is simulated; an EKF estimates it with the rigid body, with one
error of the paper (`models.printed`) and with all of them. Pen, motion, noise
and what it is told of them are the same for all, so nothing but the errors differs.

The tip pays, where a camera holds it: its acceleration is what the errors
falsify. Without a camera that acceleration is free and takes them up, and
tilt is as good or bad as with the rigid body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.tasks.history import outcome
from benchmark.tasks.task import Outcome, Quantity
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.recording import Recording, Truth
from models.arrays import Array
from models.gentle_hand import at_speed, white_jerk_writing
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import parse_pen
from models.printed import PRINTED_ERRORS, PrintedError
from models.state_space import StateSpaceModel
from pen_mhe.errors import ERROR_COLUMNS
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from suites.pen_quantities import pen_quantities

MOTION = "handwriting"
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Factors of the motion's own speed."""
CASES: Mapping[str, float] = MappingProxyType({f"speed {speed:g}": speed for speed in SPEEDS})
DURATION_S, SETTLING_S = 4.0, 1.0
"""Length of a run, and its begin that is left out of the errors."""

RIGID_BODY, AS_PRINTED = "rigid body", "as printed"
MODELS: Mapping[str, tuple[PrintedError, ...]] = MappingProxyType(
    {
        RIGID_BODY: (),
        **{f"{error} only": (error,) for error in PRINTED_ERRORS},
        AS_PRINTED: PRINTED_ERRORS,
    }
)
"""The estimator's model → the errors that it makes."""

PEN: Mapping[str, Any] = MappingProxyType(
    {
        "name": "pen of [Pen]",
        "degrees_of_freedom": 5,
        "prior": {
            "tip_std_m": 0.1,
            "azimuth_deg": -30,
            "azimuth_std_deg": 10,
            "elevation_deg": 50,
            "elevation_std_deg": 10,
        },
        "sensors": {
            "accel": {
                "preset": "LSM6DS3-accelerometer",
                "position_mm": [0, 0, 100],
                "range_g": 4,
                "resolution_mg": 0.122,
                "rate_hz": 100,
            },
            "gyro": {
                "preset": "LSM6DS3-gyroscope",
                "axes": ["x", "y"],
                "range_deg_s": 500,
                "resolution_deg_s": 0.0175,
                "rate_hz": 100,
            },
            "camera": {
                "kind": "pose_camera",
                "position_mm": [0, 0, 140],
                "position_std_mm": 0.3,
                "orientation_std_deg": 0.3,
                "rate_hz": 30,
            },
            "area": {"kind": "writing_area", "centre_mm": [50, 0, 0]},
        },
    }
)
"""State (1) and readings (9), so no bias and no third rate, with sensors of today.

The prior says how a pen is held. A run that begins 12° off it still shows, without a camera,
how slowly an EKF recovers from a bad start: that is most of the spread there.
"""


@dataclass(frozen=True)
class PrintedConfiguration:
    """Sensors, and the columns of `ERROR_COLUMNS` that they make observable."""

    sensors: tuple[str, ...]
    columns: tuple[str, ...]


CONFIGURATIONS: Mapping[str, PrintedConfiguration] = MappingProxyType(
    {
        "with camera": PrintedConfiguration(
            ("accel", "gyro", "camera"), ("elevation_deg", "azimuth_deg", "tip_mm")
        ),
        "without camera": PrintedConfiguration(("accel", "gyro", "area"), ("elevation_deg",)),
    }
)
TIP_SPEED, ACCEL_ERROR, ACCEL_NOISE = "tip speed", "accelerometer error", "accelerometer noise"
ESTIMATED = ("tip", "elevation", "azimuth")


def paper_pen(errors: Sequence[PrintedError] = (), speed: float = 1.0) -> PenConfig:
    """Return the pen whose model makes some errors, prior and motion fit for a speed."""
    prior = {**PEN["prior"], **at_speed("prior", speed)}
    motion = white_jerk_writing(speed).model_dump()
    return parse_pen({**PEN, "prior": prior, "motion": motion, "printed_errors": errors})


def simulated(speed: float, seed: int, duration_s: float) -> Recording:
    """Simulate the rigid body at a speed, all its sensors; a seed is one motion and its noise."""
    pen = paper_pen(speed=speed)
    return simulate(pen, None, motion=MOTION, duration_s=duration_s, seed=seed, speed=speed)


@dataclass(frozen=True)
class CostCase:
    """A model at a speed with the sensors of a configuration.

    Parameters
    ----------
    speed : factor of the motion's own speed
    sensors : a key of `CONFIGURATIONS`
    model : a key of `MODELS`
    """

    speed: float
    sensors: str
    model: str


def run_cost(case: CostCase, seed: int, duration_s: float = DURATION_S) -> Outcome:
    """Return what a model costs in a run.

    `TIP_SPEED`; `ACCEL_ERROR`: length of what the model's accelerometer says too much;
    `ACCEL_NOISE`: standard deviation of one axis; and the errors of the estimate.

    Parameters
    ----------
    seed : of motion and noise
    """
    recording = _recording(case.speed, seed, duration_s)
    rigid, model = (_model(case.speed, case.sensors, name) for name in (RIGID_BODY, case.model))
    history = run(_ekf(case), recording.select([each.name for each in model.measured_sensors]))
    return outcome(
        model.name,
        history,
        [
            Quantity.of_errors(TIP_SPEED, "mm/s", 1e3 * _tip_velocity(recording)),
            Quantity.of_errors(ACCEL_ERROR, "m/s²", accelerometer_error(model, rigid, recording)),
            Quantity.single(ACCEL_NOISE, "m/s²", float(model.sensor("accel").noise_std[0])),
            *_estimation_errors(case, model, history, _truth(recording)),
        ],
    )


@lru_cache(maxsize=64)
def _recording(speed: float, seed: int, duration_s: float) -> Recording:
    return simulated(speed, seed, duration_s)


@lru_cache(maxsize=2)
def _model(speed: float, sensors: str, name: str) -> StateSpaceModel:
    return pen_model(paper_pen(MODELS[name], speed), CONFIGURATIONS[sensors].sensors)


@lru_cache(maxsize=1)
def _ekf(case: CostCase) -> Estimator[Any]:
    return create_estimator("ekf", _model(case.speed, case.sensors, case.model))


def accelerometer_error(
    model: StateSpaceModel, true_model: StateSpaceModel, recording: Recording
) -> Array:
    """Return what a model's accelerometer reads beyond the true one's (n, 3), m/s²."""
    states = _truth(recording).values.T
    wrong, right = (m.sensor("accel").h(states).full() for m in (model, true_model))
    return np.asarray((wrong - right).T)


def _estimation_errors(
    case: CostCase, model: StateSpaceModel, history: EstimateHistory, truth: Truth
) -> list[Quantity]:
    """Return the errors of tip, azimuth and elevation; of the rates the sensors say it all."""
    columns = CONFIGURATIONS[case.sensors].columns
    shown = {name for column in columns for name in ERROR_COLUMNS[column][0]}
    seen = {name: name in shown for name in history.names}
    found = pen_quantities(model, history, truth, seen, settling_s=SETTLING_S)
    return [quantity for quantity in found if quantity.name in ESTIMATED]


def _truth(recording: Recording) -> Truth:
    assert recording.truth is not None
    return recording.truth


def _tip_velocity(recording: Recording) -> Array:
    truth = _truth(recording)
    return truth.values[:, [truth.names.index(f"tip_{axis}_velocity_m_s") for axis in "xyz"]]
