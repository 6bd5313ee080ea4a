"""Which pen is asked, and with which choices of its sensors."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Mapping
from typing import Any

from benchmark.tasks.suite import Scope
from models.errors import InputError
from models.pen_config import PenConfig
from models.pen_file import load_pen
from recordings.simulate_pen import sensors_with_a_rate

PEN = "dpoint"
"""The pen, unless one of one's own is given."""


def pen_of(scope: Scope) -> PenConfig:
    """Return the pen that is asked; raises `InputError` where it cannot be read."""
    return load_pen(scope.pen or PEN)


def choices(pen: PenConfig) -> list[tuple[str, ...]]:
    """Return all sensors that can be simulated, and these without those that see the pose.

    Left out is what reads no motion: a place, rest, and touch, which no drawn truth knows.

    Raises
    ------
    InputError
        If none is left.
    """
    sensors = {name: pen.sensors[name] for name in sensors_with_a_rate(pen)}
    moving = tuple(
        name
        for name, sensor in sensors.items()
        if sensor.place_m is None and not sensor.is_rest and not sensor.reads_touch
    )
    blind = tuple(name for name in moving if not sensors[name].sees_pose)
    found = [names for names in dict.fromkeys((moving, blind)) if names]
    if not found:
        raise InputError(
            f"pen {pen.name} has no sensor with a rate that reads its motion, expected one"
        )
    return found


def made_of(scope: Scope) -> str:
    """Return a hash of a pen of one's own, as it is read; empty without one."""
    if scope.pen is None:
        return ""
    return hashlib.sha256(pen_of(scope).model_dump_json().encode()).hexdigest()[:16]


def own(scope: Scope) -> Mapping[str, Any]:
    """Return the command that asks a pen of one's own again; nothing without one."""
    if scope.pen is None:
        return {}
    words = ["pen-mhe", "benchmark", "consistency", "--pen", scope.pen, "--seeds", str(scope.seeds)]
    for option, asked in (("--estimators", scope.estimators), ("--cases", scope.cases)):
        words += [option, ",".join(asked)] if asked else []
    return {"again": shlex.join(words)}
