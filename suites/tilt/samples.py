"""What every estimator of the suite is given: one set of samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from classical_baseline.tilt_conversion import AdcConversion
from estimation.recording import Recording
from models.arrays import Array
from models.names import unknown
from models.random_streams import Seed, seed_sequence
from models.simulation import sample_times, simulate_readings, states_along, union_of_times
from models.turntable import TurntableConfig, load_turntable, turntable_model
from suites.tilt.cases import CASES, Installation, TiltCase
from suites.tilt.turns import gravity_direction

SENSORS = ("accel", "gyro")
CONVERSION = AdcConversion()
"""16 bit, 5 V, 478.5 mV/g as published."""


@dataclass(frozen=True, eq=False)
class TiltSamples:
    """One recording of a case.

    Parameters
    ----------
    time_s : (n,)
    counts : (n, 3) of the converter behind the accelerometer
    acceleration_g : (n, 3) converted back, (1)-(3); the estimators begin with these
    rates : (n, 2) about x and y, rad/s
    direction : (n, 3) of gravity, the truth
    """

    time_s: Array
    counts: NDArray[np.int64]
    acceleration_g: Array
    rates: Array
    direction: Array

    def recording(self, gravity_m_s2: float) -> Recording:
        """Return the same samples for an estimator with a model; no truth."""
        readings = {"accel": gravity_m_s2 * self.acceleration_g, "gyro": self.rates}
        return Recording("tilt tracker", self.time_s, readings)


@cache
def tilt_tracker() -> TurntableConfig:
    """Return the carrier, ``models/turntables/tilt_tracker.toml``."""
    return load_turntable(Path(str(resources.files("models") / "turntables" / "tilt_tracker.toml")))


def case_named(name: str) -> TiltCase:
    """Return a case of the table; raises `InputError` for an unknown one."""
    if name not in CASES:
        raise unknown("case", name, CASES)
    return CASES[name]


def installed(installation: Installation) -> TurntableConfig:
    """Return the carrier with the sensors of an installation, as models are told of them."""
    tracker = tilt_tracker()
    changes: Mapping[str, dict[str, Any]] = {
        "accel": _louder(tracker, "accel", installation.accelerometer_noise),
        "gyro": _louder(tracker, "gyro", installation.gyroscope_noise)
        | {"bias_std_rad_s": float(np.radians(installation.gyroscope_bias_deg_s))},
    }
    sensors = {name: tracker.sensors[name].model_copy(update=changes[name]) for name in SENSORS}
    return tracker.model_copy(update={"sensors": sensors})


def _louder(tracker: TurntableConfig, sensor: str, factor: float) -> dict[str, Any]:
    told = tracker.sensors[sensor].model_dump()
    return {key: factor * told[key] for key in told if key.startswith("noise_density")}


def simulate_samples(case: TiltCase, seed: Seed) -> TiltSamples:
    """Turn the carrier and read its sensors: simulated, converted to counts and back."""
    # The bias is one of the installation, not one more draw.
    without_bias = Installation(
        case.installation.accelerometer_noise, case.installation.gyroscope_noise
    )
    model, root = turntable_model(installed(without_bias), SENSORS), seed_sequence(seed)
    times = sample_times(model, case.turn.duration_s)
    time_s = union_of_times(times)
    path = case.turn.states(time_s)
    named = dict(zip(model.state_names, path.T, strict=True))
    states = states_along(model, time_s, named, root, times)
    readings = simulate_readings(model, times, time_s, states, root).sensors
    counts = CONVERSION.counts(readings["accel"][1] / tilt_tracker().gravity_m_s2)
    return TiltSamples(
        time_s,
        counts,
        CONVERSION.acceleration_g(counts),
        readings["gyro"][1] + np.radians(case.installation.gyroscope_bias_deg_s),
        gravity_direction(path[:, 0], path[:, 1]),
    )
