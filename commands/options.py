"""Options that several commands share, and how their texts are read."""

from __future__ import annotations

import contextlib
import csv
from typing import Annotated

import typer

from commands.lists import complete_sensors, completing
from models.errors import InputError

PenOption = Annotated[
    str,
    typer.Option(
        help="Pen file, or a bundled pen: {pens}.",
        autocompletion=completing("pens"),
    ),
]
PenOrNoneOption = Annotated[
    str | None,
    typer.Option(
        help="Pen file, or a bundled pen: {pens}; without one, what the recording shows.",
        autocompletion=completing("pens"),
    ),
]
SensorsOption = Annotated[
    str | None,
    typer.Option(
        help="Names from the pen file, with commas; by default all that can be used.",
        autocompletion=complete_sensors,
    ),
]
WritingAreaOption = Annotated[
    bool,
    typer.Option(help="Where no sensor sees a position, hold the tip to the writing area."),
]
RestOption = Annotated[
    bool,
    typer.Option(help="Where the pen file has a sensor of rest, add it to a gyroscope."),
]
JobsOption = Annotated[int, typer.Option(help="Processes.", min=1)]


def names(text: str | None) -> tuple[str, ...] | None:
    """Split ``accel,gyro``, or ``tilt,"free pen, writing"`` as in a CSV; None stays None.

    Raises
    ------
    InputError
        If there is no name between the commas.
    """
    if text is None:
        return None
    row = next(csv.reader([text], skipinitialspace=True), [])
    found = tuple(name.strip() for name in row if name.strip())
    if not found:
        raise InputError(f"list {text!r} has no name in it, expected e.g. accel,gyro")
    return found


def thresholds(text: str | None) -> dict[str, float]:
    """Read ``accel=2,camera=3`` into sensor → threshold in standard deviations."""
    pairs = [pair.split("=") for pair in text.split(",")] if text else []
    try:
        return {sensor.strip(): float(value) for sensor, value in pairs}
    except ValueError:
        raise InputError(f"thresholds {text!r}, expected e.g. accel=2,camera=3") from None


def ipopt_options(text: str | None) -> dict[str, int | float | str]:
    """Read ``max_iter=500,mu_strategy=adaptive`` into option → whole number, number or text."""
    pairs = [pair.split("=") for pair in text.split(",")] if text else []
    if any(len(pair) != 2 for pair in pairs):
        raise InputError(f"IPOPT options {text!r}, expected e.g. max_iter=500,mu_strategy=adaptive")
    return {name.strip(): _number_or_text(value.strip()) for name, value in pairs}


def _number_or_text(text: str) -> int | float | str:
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def units(text: str | None) -> dict[str, str]:
    """Read ``accel=g,gyro=deg_s`` into sensor → unit."""
    pairs = [pair.split("=") for pair in text.split(",")] if text else []
    if any(len(pair) != 2 for pair in pairs):
        raise InputError(f"units {text!r}, expected e.g. accel=g,gyro=deg_s")
    return {sensor.strip(): unit.strip() for sensor, unit in pairs}
