"""What a pen's sensors can see: the verdict along motions of the table.

The readings themselves hardly matter: the verdict is taken along the true motion,
no estimator takes part.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from estimation.observability import Verdict, verdict
from estimation.recording import Recording
from models.errors import InputError
from models.pen import PenConfig, pen_model
from models.state_space import StateSpaceModel
from recordings.simulate_pen import sensors_with_a_rate, simulate

MOTIONS = ("still", "handwriting")
"""Motions that the verdict is given for: what rest leaves open, writing may show."""


@dataclass(frozen=True, eq=False)
class SensorVerdict:
    """The verdict on one choice of sensors, by motion."""

    model: StateSpaceModel
    by_motion: dict[str, Verdict]


def judge(model: StateSpaceModel, recording: Recording) -> Verdict:
    """Return what a configuration can see along the true motion of a recording.

    Raises
    ------
    InputError
        If the recording has no truth, or it lacks a state of the model.
    """
    if recording.truth is None:
        raise InputError(f"recording {recording.name} has no truth, expected it to judge by")
    states = recording.truth.states(model.state_names, recording.time_s)
    missing = np.array(model.state_names)[np.isnan(states).any(axis=0)]
    if len(missing):
        raise InputError(
            f"recording {recording.name}: its truth lacks {', '.join(missing)}, "
            "expected every state of the model to judge by"
        )
    return verdict(model, list(recording.measurements(model)), states)


def observe(
    pen: PenConfig,
    sensors: Iterable[str] | None = None,
    writing_area: bool = True,
    motions: Iterable[str] = MOTIONS,
    duration_s: float = 3.0,
) -> SensorVerdict:
    """Judge a choice of sensors along motions of the table.

    Parameters
    ----------
    sensors : names from the pen file; None takes all that have a rate
    writing_area : see `models.pen.pen_model`
    motions : names of `models.motions.motions`
    duration_s : of each motion
    """
    chosen = sensors_with_a_rate(pen) if sensors is None else sensors
    model = pen_model(pen, chosen, writing_area)
    measured = [sensor.name for sensor in model.measured_sensors]
    return SensorVerdict(
        model,
        {
            motion: judge(model, simulate(pen, measured, motion=motion, duration_s=duration_s))
            for motion in motions
        },
    )
