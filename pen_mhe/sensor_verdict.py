"""What a pen's sensors can see: the verdict along motions of the table.

The readings themselves hardly matter: the verdict is taken along the true motion,
no estimator takes part.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from estimation.observability import Verdict, verdict
from estimation.outputs import outputs_of
from estimation.recording import Recording
from models.errors import InputError
from models.names import several
from models.pen import pen_model
from models.pen_file import AnyPen, as_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import sensors_with_a_rate, simulate

MOTIONS = ("still", "handwriting")
"""Motions that the verdict is given for: what rest leaves open, writing may show."""


@dataclass(frozen=True, eq=False, repr=False)
class SensorVerdict:
    """The verdict on one choice of sensors, by motion; prints itself as a table."""

    model: StateSpaceModel
    by_motion: dict[str, Verdict]

    def rows(self) -> list[list[str]]:
        """Return a row per output: name, what was known before, and a verdict per motion."""
        outputs = outputs_of(self.model)
        first = next(iter(self.by_motion.values())).bound
        states = zip(outputs.names, outputs.units, first.prior_std, strict=True)
        return [
            [name, f"{std:.3g} {unit}", *(_seen(v, i, name) for v in self.by_motion.values())]
            for i, (name, unit, std) in enumerate(states)
            if unit != "1"  # a quaternion says again what the angles say
        ]

    def __repr__(self) -> str:
        rows = [["state", "known before (std)", *self.by_motion], *self.rows()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [f"{self.model.name}: {', '.join(s.name for s in self.model.sensors)}"]
        lines += ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
        for motion, found in self.by_motion.items():
            seen = found.observability
            lines.append(f"{motion}: {seen.rank} of {self.model.n_x} directions are observable")
            lines += [f"  no reading shows {direction.words}" for direction in seen.directions]
        return "\n".join(lines)


def _seen(verdict: Verdict, index: int, name: str) -> str:
    left = f"{min(verdict.unseen_fraction[index], 1):.1%}"
    return left if verdict.sees(name) else f"not observable ({left})"


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
    pen: AnyPen = "reference",
    sensors: Iterable[str] | None = None,
    *,
    writing_area: bool = True,
    motions: Iterable[str] = MOTIONS,
    duration_s: float = 3.0,
) -> SensorVerdict:
    """Judge what a choice of sensors can see, along motions of the table.

    Parameters
    ----------
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names from the pen file; None takes all that have a rate
    writing_area : see `models.pen.pen_model`
    motions : names of `models.motions.motions`
    duration_s : of each motion
    """
    config = as_pen(pen)
    chosen = sensors_with_a_rate(config) if sensors is None else sensors
    model = pen_model(config, chosen, writing_area=writing_area)
    measured = [sensor.name for sensor in model.measured_sensors]
    return SensorVerdict(
        model,
        {
            motion: judge(model, simulate(config, measured, motion=motion, duration_s=duration_s))
            for motion in several(motions)
        },
    )
