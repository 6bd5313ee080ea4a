"""A simulated recording of a pen: motion, readings, truth."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from estimation.recording import Recording, Truth
from models.motions import minimum_jerk, stroke
from models.pen import PenConfig, pen_model
from models.simulation import sample_times, simulate_readings, true_states, union_of_times


def simulate_recording(
    pen: PenConfig,
    sensors: Iterable[str] | None = None,
    stroke_name: str = "turn",
    duration_s: float = 3.0,
    seed: int = 0,
) -> Recording:
    """Simulate a stroke of a pen.

    Parameters
    ----------
    pen : the pen
    sensors : names of its sensors; None takes all
    stroke_name : one of `models.motions.strokes`
    duration_s : s
    seed : of the noise; the same seed gives the same recording
    """
    model = pen_model(pen, sensors)
    rng = np.random.default_rng(seed)
    times = sample_times(model, duration_s)
    motion = minimum_jerk(stroke_name, stroke(stroke_name), union_of_times(times))
    states = true_states(model, motion, rng)
    readings = simulate_readings(model, times, motion.time_s, states, rng)
    truth = Truth(readings.time_s, model.state_names, readings.states)
    return Recording.from_sensors(f"{stroke_name} (simulated)", readings.sensors, truth)
