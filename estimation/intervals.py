"""Times between readings, of a model that is defined over whole numbers of an interval only."""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.linear_steps import INTERVAL_TOLERANCE
from models.state_space import StateSpaceModel


def check_intervals(recording: str, time_s: Array, model: StateSpaceModel) -> None:
    """Raise `InputError` unless times (n,) are whole numbers of a model's intervals apart."""
    if model.interval_s is None:
        return
    steps = np.diff(time_s) / model.interval_s
    off = np.abs(steps - np.round(steps)) > INTERVAL_TOLERANCE
    if not off.any() and (np.round(steps) >= 1).all():
        return
    row = int(np.argmax(off | (np.round(steps) < 1)))
    raise InputError(
        f"recording {recording}: {time_s[row + 1] - time_s[row]:g} s between rows {row} and "
        f"{row + 1}, but model {model.name} holds for steps of {model.interval_s:g} s, expected a "
        "whole number of them (or matrices of continuous time, without dt_s)"
    )


def check_step(model: StateSpaceModel, before: float | None, time_s: float) -> None:
    """Raise `InputError` unless a live step is a whole number of a model's intervals long.

    Parameters
    ----------
    before : time of the last measurement; None before the first. An older one than that is late
    """
    if model.interval_s is None or before is None or not time_s > before:
        return
    steps = (time_s - before) / model.interval_s
    if abs(steps - round(steps)) > INTERVAL_TOLERANCE:
        raise InputError(
            f"{time_s - before:g} s since the last measurement, but model {model.name} holds for "
            f"steps of {model.interval_s:g} s, expected a whole number of them"
        )
