"""What is simulated and who estimates it: the protocol of ``faults.toml``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import isnan
from pathlib import Path
from types import MappingProxyType

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from benchmark.from_mhe import REFERENCE
from estimation.recording import Recording
from models.arrays import Array
from models.gentle_hand import at_speed, bounded_writing
from models.motions import sample_motion
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.random_streams import seed_sequence, stream
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from suites.faults.table import FILE, Fault, faults

MOTION = "handwriting"
SENSORS = (
    *("accel+gyro", "accel+gyro+camera"),
    *("two accelerometers", "two accelerometers+camera"),
)
"""Keys of `benchmark.configurations.CONFIGURATIONS`."""

ESTIMATORS: Mapping[str, Mapping[str, int]] = MappingProxyType(
    {**dict.fromkeys(BENCHMARK_ESTIMATORS, MappingProxyType({})), REFERENCE: {"horizon": 8}}
)
"""Estimator → settings of it."""

TARGETS = ("imu", "gyro", "accel", "camera", "all")

ANGLES = ("azimuth_rad", "elevation_rad", "spin_rad")
TIP = ("tip_x_m", "tip_y_m", "tip_z_m")
TILT = ANGLES[1:]
"""What gravity shows of an attitude."""


@cache
def writers_pen() -> PenConfig:
    """Return the reference pen, told the hand that moves it."""
    return written_by_hand(load_pen("reference"))


def written_by_hand(pen: PenConfig) -> PenConfig:
    """Return a pen, told the hand that moves it."""
    prior = pen.prior.model_copy(update=at_speed("prior"))
    return pen.model_copy(update={"motion": bounded_writing(), "prior": prior})


@cache
def model_of(sensors: str) -> StateSpaceModel:
    """Return the model of the pen with a choice of sensors."""
    return pen_model(writers_pen(), CONFIGURATIONS[sensors].sensors)


def recorded(sensors: str, seed: int, duration_s: float, speed: float = 1.0) -> Recording:
    """Return the fault-free recording, with its truth."""
    return simulate(
        writers_pen(),
        CONFIGURATIONS[sensors].sensors,
        motion=MOTION,
        duration_s=duration_s,
        seed=seed,
        speed=speed,
    )


def true_motion(seed: int, time_s: Array, speed: float = 1.0) -> dict[str, Array]:
    """Return the true tip and angles by name, (n,) each, at any times."""
    rng = stream(seed_sequence(seed), "motion")
    q = sample_motion(MOTION, time_s, seed=rng, speed=speed).q
    return dict(zip((*TIP, *ANGLES), np.asarray(q).T, strict=True))


def judged_quantities(model: StateSpaceModel) -> tuple[str, ...]:
    """Return what the sensors show: tilt, and with a camera the azimuth and the tip too."""
    return (*ANGLES, *TIP) if any(sensor.sees_pose for sensor in model.sensors) else TILT


def targets_of(model: StateSpaceModel, target: str) -> tuple[str, ...]:
    """Return the names of the sensors that a target of the table means; none where it has none.

    ``accel`` of two accelerometers is the first of them alone.
    """
    inertial = [s for s in model.measured_sensors if s.feels_gravity or s.reads_rate]
    found: dict[str, list[SensorModel]] = {
        "imu": inertial,
        "gyro": [s for s in inertial if s.reads_rate],
        "accel": [s for s in inertial if s.feels_gravity][:1],
        "camera": [s for s in model.measured_sensors if s.sees_pose],
        "all": list(model.measured_sensors),
    }
    return tuple(sensor.name for sensor in found[target])


def faults_for(sensors: str, table: Path = FILE) -> tuple[Fault, ...]:
    """Return the faults of a table that a choice of sensors can have, each once.

    Left out are those of sensors that it lacks, and those that hit the same sensors in the same
    way as one before: where all sensors are inertial, ``all`` is ``imu``.
    """
    model, found = model_of(sensors), dict[tuple[Fault, tuple[str, ...]], Fault]()
    for fault in faults(table).values():
        hit = targets_of(model, fault.of)
        if hit and all(targets_of(model, needed) for needed in fault.needs):
            alike = replace(fault, key="", of="", size=0.0 if isnan(fault.size) else fault.size)
            found.setdefault((alike, hit), fault)
    return tuple(found.values())
