"""A pen with a magnetometer, and recordings of it with iron nearby."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

import pen_mhe as pm
from estimation.recording import Recording
from models.pen_body import rates_and_attitudes
from models.pen_file import load_pen

Array = NDArray[np.float64]

SENSORS = ("accel", "gyro", "mag")
FIELD = {"field_strength_ut": 48.0, "field_dip_deg": 64.0}
"""Of central Europe."""


def compass_pen() -> pm.PenConfig:
    """Return the bundled pen with a compass."""
    return load_pen("compass")


@cache
def written(seed: int, duration_s: float = 10.0) -> Recording:
    """Return simulated handwriting."""
    return pm.simulate(
        compass_pen(), SENSORS, motion="handwriting", duration_s=duration_s, seed=seed
    )


def near_iron(
    recording: Recording, field_ut: Array, *, start_s: float, for_s: float, ramp_s: float
) -> Recording:
    """Return a recording whose magnetometer also reads a field of the room for a while.

    Parameters
    ----------
    field_ut : (3,) world axes
    ramp_s : how long it takes to come and to go
    """
    assert recording.truth is not None
    pen = compass_pen()
    model = pm.pen_model(pen, SENSORS)
    times, y = recording.sensor("mag")
    states = recording.truth.states(model.state_names, times)
    world_to_body = rates_and_attitudes(pen, states)[1]
    inside = np.minimum(times - start_s, start_s + for_s - times)
    share = np.clip(inside / ramp_s, 0, 1) if ramp_s else (inside >= 0).astype(float)
    changed = y + share[:, None] * (world_to_body @ field_ut)
    return replace(recording, readings={**recording.readings, "mag": changed})


def azimuth_error(history: pm.EstimateHistory, recording: Recording) -> Array:
    """Return the error of the azimuth (n,), rad, the short way round."""
    assert recording.truth is not None
    true = recording.truth.states(["azimuth_rad"], history.time_s)[:, 0]
    away = history.column("azimuth_rad") - true
    return np.asarray((away + np.pi) % (2 * np.pi) - np.pi)
