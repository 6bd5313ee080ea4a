"""The example program of an export: from a recording's columns to estimates."""

from __future__ import annotations

from collections.abc import Sequence

from codegen.constant_readings import given_names, measured_columns
from codegen.export import Export
from codegen.names import macros
from codegen.structures import braces
from codegen.template import filled
from estimation.outputs import derived_outputs, outputs_of
from estimation.status import Status
from models.escaped import c_string
from models.state_space import StateSpaceModel
from models.units import TIME_DIGITS, UNITS


def example_program(export: Export) -> str:
    """Return the text of main.c."""
    model, prefix = export.exported.model, export.prefix
    names = given_names(model)
    bits = [
        f"{{{prefix.upper()}_STATUS_{name}, {c_string(member.label)}}}"
        for name, member in Status.__members__.items()
        if member is not Status.SOLVED
    ]
    return filled(
        "main.c",
        prefix=prefix,
        PREFIX=prefix.upper(),
        columns=braces([f"{{{c_string(h)}, {i}, {f!r}}}" for h, (i, f) in headers(model).items()]),
        readings=braces([c_string(name) for name in names]),
        shown=braces(_shown(model, prefix.upper())),
        statuses=braces(bits),
        solved=Status.SOLVED.label,
        digits="17" if export.precision.c_type == "double" else "9",
        time_digits=str(TIME_DIGITS),
        per_tick=f"1e{TIME_DIGITS}",
    )


def _shown(model: StateSpaceModel, capital: str) -> list[str]:
    """Return the rows of what people read: its name, and where its value and spread stand."""
    derived = derived_outputs(model).names
    rows = {name: f"STATE({capital}_STATE_{macro})" for name, macro in _macros(model.state_names)}
    rows |= {name: f"DERIVED({capital}_DERIVED_{macro})" for name, macro in _macros(derived)}
    return [f"{{{c_string(name)}, {rows[name]}}}" for name in outputs_of(model).names]


def _macros(names: Sequence[str]) -> list[tuple[str, str]]:
    return list(zip(names, macros(names), strict=True))


def headers(model: StateSpaceModel) -> dict[str, tuple[int, float]]:
    """Return header → place of the reading (-1 for the time) and factor to SI.

    Those that ``pen-mhe estimate`` takes: with any unit of the quantity, or without one in SI.
    """
    found = {f"time_{unit}": (-1, factor) for unit, factor in UNITS["s"].items()}
    units = [unit for sensor in model.sensors for unit in sensor.unit_of_axis]
    units += [""] * model.n_u  # an input's name says its unit
    for place, (column, name) in enumerate(
        zip(measured_columns(model), given_names(model), strict=True)
    ):
        found[name] = (place, 1.0)
        for unit, factor in UNITS.get(units[column], {}).items():
            found[f"{name}_{unit}"] = (place, factor)
    return found
