"""What of a pen can be tuned: noises, walks and the numbers of its chains, found by their fields.

A parameter is a positive number with a key of the pen file. Nothing asks which kind of sensor it
belongs to: the names of a sensor's own fields say what they are. What a data sheet says of a
bias before the first reading (``bias_std_…``), and the prior, are not tuned.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from models.config import UnitConfig
from models.errors import InputError
from models.names import expected_one_of
from models.pen_config import PenConfig
from models.units import accepted_names, split_unit

MOTION, SENSORS = "motion", "sensors"
"""Tables of a pen file."""

SENSOR_FIELDS: Mapping[str, re.Pattern[str]] = MappingProxyType(
    {"walk": re.compile("bias_walk"), "noise": re.compile("noise_density|(?!bias).*std")}
)
"""Role of a parameter → how its field begins, without the unit."""

SMALLEST_WALK = 1e-2
"""Of a bias' prior, per √s: where a walk starts that the file has as zero."""


@dataclass(frozen=True)
class Parameter:
    """One number of a pen file.

    Parameters
    ----------
    role : ``noise``, ``walk`` or ``chain``
    table : where it stands: ``("sensors", "accel")``, ``("motion", "tip")``; ``()`` on top
    field : its key in SI
    sees_pose : whether it is a noise of a sensor that does, see
        `models.sensor_kinds.mounted.SensorBase`
    """

    role: str
    table: tuple[str, ...]
    field: str
    sees_pose: bool = False

    @property
    def key(self) -> str:
        """With its table, in SI: ``sensors.camera.position_std_m``."""
        return ".".join((*self.table, self.field))

    def value(self, pen: PenConfig) -> float:
        """Return its value in a pen, SI."""
        return float(getattr(_table(pen, self.table), self.field))

    def start(self, pen: PenConfig) -> float:
        """Return its value where a search begins: positive, also of a walk that is zero."""
        value = self.value(pen)
        if value > 0:
            return value
        unit = split_unit(self.field)[1].removesuffix("_per_sqrt_s")
        return SMALLEST_WALK * float(getattr(_table(pen, self.table), f"bias_std_{unit}"))

    def is_meant_by(self, text: str) -> bool:
        """Whether a text is its key, in any unit, or begins it: ``motion``, ``sensors.camera``."""
        table, _, key = text.rpartition(".")
        units = accepted_names(self.field)
        is_whole = table == ".".join(self.table) and key in units
        return is_whole or f"{self.key}_".startswith((f"{text}.", f"{text}_"))


def _table(pen: PenConfig, table: tuple[str, ...]) -> UnitConfig:
    if not table:
        return pen
    top, name = table
    found: Any = getattr(pen, top)
    return found[name] if top == SENSORS else getattr(found, name)


def parameters_of(pen: PenConfig, sensors: Sequence[str]) -> tuple[Parameter, ...]:
    """Return all that can be tuned of a pen with some of its sensors, chains first."""
    found = [
        Parameter("chain", (MOTION, part), field)
        for part in type(pen.motion).model_fields
        for field, value in getattr(pen.motion, part)
        if isinstance(value, float)
    ]
    for name in sensors:
        sensor = pen.sensors[name]
        for field in type(sensor).model_fields:
            stem, value = split_unit(field)[0], getattr(sensor, field)
            for role, pattern in SENSOR_FIELDS.items():
                if not pattern.fullmatch(stem.split("_per_")[0]) or not isinstance(value, float):
                    continue
                if role == "walk" and not sensor.bias_states(name).names:
                    continue  # no bias that could walk
                is_pose = role == "noise" and sensor.sees_pose
                found.append(Parameter(role, (SENSORS, name), field, is_pose))
    return tuple(found)


def chosen_parameters(
    available: Sequence[Parameter], texts: Sequence[str]
) -> tuple[Parameter, ...]:
    """Return the parameters that keys, or beginnings of keys, name.

    Raises
    ------
    InputError
        If one of the texts names none.
    """
    for text in texts:
        if not any(parameter.is_meant_by(text) for parameter in available):
            known = [parameter.key for parameter in available]
            raise InputError(f"parameter {text} is unknown; {expected_one_of(text, known)}")
    return tuple(p for p in available if any(p.is_meant_by(text) for text in texts))


def with_values(pen: PenConfig, values: Mapping[Parameter, Any]) -> PenConfig:
    """Return a pen with other values, SI, which are not checked: they may be symbols."""
    for parameter, value in values.items():
        if not parameter.table:
            pen = pen.model_copy(update={parameter.field: value})
            continue
        top, name = parameter.table
        changed = _table(pen, parameter.table).model_copy(update={parameter.field: value})
        whole: Any = getattr(pen, top)
        renewed = (
            {**whole, name: changed} if top == SENSORS else whole.model_copy(update={name: changed})
        )
        pen = pen.model_copy(update={top: renewed})
    return pen


def rounded(value: float, digits: int = 4) -> float:
    """Return a number with so many significant digits."""
    return float(f"{value:.{digits}g}") if math.isfinite(value) else value
