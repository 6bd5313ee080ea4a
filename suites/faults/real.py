"""Real recordings, in which nothing is broken: what a watch says of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.configurations import CONFIGURATIONS
from benchmark.tasks.task import Quantity, Task
from estimation.estimator import Estimator, run
from estimation.history import EstimateHistory
from estimation.recording import Recording
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen, parse_pen
from pen_mhe.estimators import create_estimator
from recordings.formats.dpoint import load_dpoint
from recordings.formats.imu_array import ImuArray, calibrated, read_imu_array, still_poses
from suites.faults.clean import flags_raised
from suites.faults.contenders import CONTENDERS
from suites.faults.quantities import REAL_FLAGS
from suites.faults.said import Said

DPOINT, ARRAY = "D-POINT", "array"

ARRAY_PEN = {
    "name": "an IMU of the array",
    "prior": {"elevation_rad": 1.2, "elevation_std_rad": 0.5},
    "sensors": {
        "accel": {
            "kind": "accelerometer",
            "noise_density_m_s2_per_sqrt_hz": 0.006,
            "bandwidth_hz": 31.25,
            "range_g": 16.0,
            "resolution_m_s2": 0.0048,
            "bias_std_m_s2": 0.02,
        },
        "gyro": {
            "kind": "gyroscope",
            "noise_density_deg_s_per_sqrt_hz": 0.025,
            "bandwidth_hz": 31.25,
            "range_deg_s": 2000.0,
            "resolution_deg_s": 0.061,
            "bias_std_deg_s": 0.1,
            "bias_walk_deg_s_per_sqrt_s": 0.005,
        },
    },
}
"""Noise of its still moments, steps of its converters; moved by a hand that writes or points."""


@dataclass(frozen=True)
class RealRecording:
    """A real recording, or several that are alike.

    Parameters
    ----------
    folder : within the folder of recordings
    count : how many; a seed is one of them
    sensors : choices of them that are judged
    pen : that it is told to be of
    load : folder of recordings and seed → the recording
    """

    folder: str
    count: int
    sensors: tuple[str, ...]
    pen: Callable[[], PenConfig]
    load: Callable[[str, int], Recording]

    def is_in(self, data: str | None) -> bool:
        """Whether a folder of recordings has it."""
        return data is not None and (Path(data) / self.folder).is_dir()


@cache
def _dpoint(data: str, seed: int) -> Recording:
    return load_dpoint(Path(data) / REAL[DPOINT].folder, load_pen("dpoint")).recording


@cache
def _array(data: str) -> ImuArray:
    return calibrated(read_imu_array(Path(data) / REAL[ARRAY].folder), 9.81)


def _imu(data: str, seed: int) -> Recording:
    """Return what one IMU read from the first still pose on until the array is shaken."""
    array = _array(data)
    poses = still_poses(array)
    longest = int(np.argmax([after.start - pose.stop for pose, after in pairwise(poses)]))
    rows = slice(poses[0].start, poses[longest].stop)
    readings = {"accel": array.force[rows, seed], "gyro": array.rate[rows, seed]}
    return Recording(f"IMU {seed} of the array", array.time_s[rows], readings)


REAL: Mapping[str, RealRecording] = MappingProxyType(
    {
        DPOINT: RealRecording(
            "dpoint_pen",
            1,
            ("accel+gyro", "accel+gyro+camera"),
            lambda: load_pen("dpoint"),
            _dpoint,
        ),
        ARRAY: RealRecording(
            "isa_imu_array", 8, ("accel+gyro",), lambda: parse_pen(ARRAY_PEN), _imu
        ),
    }
)
"""Case → recordings."""


def real_tasks(suite: str, estimator: str, data: str | None) -> list[Task]:
    """Return the tasks of an estimator on the recordings that are there."""
    return [
        Task(suite, case, sensors, estimator, seed)
        for case, row in REAL.items()
        if row.is_in(data)
        for sensors in row.sensors
        for seed in range(row.count)
    ]


def run_real(task: Task, data: str) -> tuple[str, list[Quantity], Said, EstimateHistory]:
    """Return what a contender finds: its model, how many flags, what was said, the history."""
    of = _estimator(task.case, task.estimator, task.sensors)
    recording = REAL[task.case].load(data, task.seed)
    history = run(of, recording.select(CONFIGURATIONS[task.sensors].sensors))
    told = Said.of(history)
    return of.model.name, [Quantity.single(REAL_FLAGS, "1", flags_raised(told))], told, history


@cache
def _estimator(case: str, name: str, sensors: str) -> Estimator[Any]:
    contender = CONTENDERS[name]
    model = pen_model(REAL[case].pen(), CONFIGURATIONS[sensors].sensors)
    return contender.wrap(create_estimator(contender.estimator, model))
