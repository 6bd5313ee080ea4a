"""What a calibration is given: recordings, their sensors that it is about, and a pen's text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.names import several, unknown
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText

OneGiven = Recording | str | Path


def recordings_of(
    given: OneGiven | Sequence[OneGiven], read: Callable[[str | Path], Recording]
) -> list[Recording]:
    """Return one or several recordings, read where they are paths.

    Raises
    ------
    InputError
        If none is given.
    """
    several_given = [given] if isinstance(given, Recording | str | Path) else list(given)
    if not several_given:
        raise InputError("no recording is given, expected one at least")
    return [one if isinstance(one, Recording) else read(one) for one in several_given]


def sensors_asked(
    recordings: Sequence[Recording],
    known: Sequence[str],
    names: Sequence[str] | str | None,
    *,
    kind: str,
    example: str,
) -> tuple[str, ...]:
    """Return the sensors to calibrate; None takes those that every recording has.

    Parameters
    ----------
    known : those of the pen that could be
    kind, example : what they are, in a sentence, and what a pen file would have to have

    Raises
    ------
    InputError
        If one is unknown, or a recording has none.
    """
    if names is None:
        names = [name for name in known if all(name in each.readings for each in recordings)]
        if not names:
            raise InputError(
                f"recording {recordings[0].name} has no {kind} to calibrate, expected one of "
                f"{', '.join(known) or f'{example} in the pen file'}"
            )
    for name in (names := several(names)):
        if name not in known:
            raise unknown(kind, name, known)
        for each in recordings:
            each.sensor(name)
    return names


def as_written(
    found: Iterable[Mapping[Parameter, Any]], text: PenText | None
) -> dict[Parameter, Any]:
    """Return all values, rounded as the pen file will hold them where there is one."""
    values = {p: value for each in found for p, value in each.items()}
    return values if text is None else {p: text.written(p, v) for p, v in values.items()}


def complete_readings(recording: Recording, sensor: str) -> tuple[Array, Array]:
    """Return times (n,) and readings (n, n_axes) of instants at which every axis was read."""
    times, values = recording.sensor(sensor)
    complete = ~np.isnan(values).any(axis=1)
    return times[complete], values[complete]
