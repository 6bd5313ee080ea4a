"""The public header of an export: every argument and state with its unit, from the model."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from codegen.constant_readings import constant_sensors, detected_sensors, measured_columns
from codegen.estimate_fields import FLAGGED, Field, estimate_fields, flag_field
from codegen.exportable import Exportable
from codegen.names import macros
from codegen.number_format import Precision
from codegen.template import filled
from estimation.outputs import Derived, derived_outputs
from estimation.result import result_layout
from estimation.status import SENTENCES, Status
from estimation.watch.flags import Flag
from models.escaped import in_comment
from models.state_space import StateSpaceModel
from models.units import readable_unit

_SIZES_OF = {
    "mean": ("N_X",),
    "covariance": ("N_X", "N_X"),
    "derived": ("N_DERIVED",),
    "derived_std": ("N_DERIVED",),
    "innovation": ("N_R",),
    "innovation_covariance": ("N_R", "N_R"),
    FLAGGED: ("N_SENSORS",),
    "lagged_time": ("N_LAGS",),
    "lagged_mean": ("N_LAGS", "N_X"),
    "lagged_covariance": ("N_LAGS", "N_X", "N_X"),
    "lagged_derived": ("N_LAGS", "N_DERIVED"),
    "lagged_derived_std": ("N_LAGS", "N_DERIVED"),
}
"""Member of the estimate → the sizes that its lengths are."""
_SAID_OF_A_SENSOR = {
    Flag.STUCK: "It repeats its reading, which is not used.",
    Flag.OUTLIER: "Its reading is not to be believed, and is not used.",
    Flag.INCONSISTENT: "Its readings contradict the others.",
    Flag.LEFT_OUT: "It is not used at present.",
}


def header(export: Exportable, prefix: str, precision: Precision, form: str) -> str:
    """Return the header's text."""
    model, capital = export.model, prefix.upper()
    fields = estimate_fields(result_layout(model, export.loop.lags))
    watch = export.watch
    if watch is not None:
        fields.append(flag_field(len(model.sensors)))
    derived = derived_outputs(model)
    return filled(
        "interface.h",
        prefix=prefix,
        PREFIX=capital,
        title=in_comment(title(export, precision, form)),
        real=precision.c_type,
        sizes="\n".join(_sizes(export, capital)),
        states=_enumeration(
            capital, "STATE", zip(model.state_names, model.state_units, strict=True)
        ),
        derived=_derived(capital, derived),
        lags=_lags(capital, export.loop.lags),
        readings=_readings(capital, model),
        rows=_comment(_row_words(model)),
        constants=_comment(_constant_words(model)),
        statuses=_statuses(capital),
        fields="\n".join(_member(field, prefix, capital) for field in fields),
        n_constants=str(max(len(constant_sensors(model)), 1)),
        n_memory=str(export.loop.memory.size),
        flags=_flags(capital, model) if watch else "",
        watch_memory=f"\n    {prefix}_real watch[{watch.layout.size}];" if watch else "",
    )


def title(export: Exportable, precision: Precision, form: str) -> str:
    """Return what an export is, in a line."""
    sensors = ", ".join(sensor.name for sensor in export.model.sensors)
    return (
        f"{export.estimator} for {export.model.name}, sensors {sensors}; "
        f"{precision.c_type}, {form} form"
    )


def state_units(model: StateSpaceModel) -> list[tuple[str, str]]:
    """Return (name, unit) of every state."""
    return list(zip(model.state_names, model.state_units, strict=True))


def reading_units(model: StateSpaceModel) -> list[tuple[str, str]]:
    """Return (name, unit) of every reading that a caller gives."""
    units = [unit for sensor in model.sensors for unit in sensor.unit_of_axis]
    given = measured_columns(model)[: -model.n_u or None]
    return [(model.reading_names[i], readable_unit(units[i])) for i in given]


def _sizes(export: Exportable, capital: str) -> list[str]:
    model = export.model
    given = "readings that a step is given" + (", and known inputs" if model.n_u else "")
    sizes = {
        "N_X": (model.n_x, "states"),
        "N_DERIVED": (len(derived_outputs(model).names), "numbers that are derived from states"),
        "N_Y": (len(measured_columns(model)), given),
        "N_R": (model.n_r, "rows of the innovation"),
    }
    if export.watch:
        sizes["N_SENSORS"] = (len(model.sensors), "sensors, those without readings too")
    if export.loop.lags:
        sizes["N_LAGS"] = (len(export.loop.lags), "instants before the newest that are told too")
    return [f"#define {capital}_{name} {n} /* {words} */" for name, (n, words) in sizes.items()]


def _readings(capital: str, model: StateSpaceModel) -> str:
    """Return the places of readings, and of known inputs behind them."""
    readings = reading_units(model)
    found = _enumeration(capital, "READING", readings)
    if not model.n_u:
        return found
    inputs = zip(model.input_names, model.input_units, strict=True)
    words = [
        "Known inputs, behind the readings. NaN: it is as it was before; a step that knows nothing",
        "of one yet does nothing and returns -1.",
    ]
    behind = _enumeration(capital, "INPUT", inputs, first=len(readings))
    return "\n".join([found, "", _comment(words), behind])


def _enumeration(
    capital: str, kind: str, entries: Iterable[tuple[str, str]], *, first: int = 0
) -> str:
    rows = list(entries)
    names = macros(name for name, _ in rows)
    lines = [
        f"    {capital}_{kind}_{name} = {i}, /* {in_comment(unit)} */"
        for i, (name, (_, unit)) in enumerate(zip(names, rows, strict=True), first)
    ]
    return "\n".join(["enum {", *lines, "};"]) if lines else f"/* no {kind.lower()} */"


def _derived(capital: str, derived: Derived) -> str:
    if not derived.names:
        return "/* Nothing is derived from the states: people read them as they are. */"
    words = [
        "Derived from the states, as in `derived` and `derived_std`: what people read. A standard",
        "deviation of theirs is no square root in `covariance`, whose rows of an attitude are",
        "those of a small turn about the body's axes, in rad.",
    ]
    rows = zip(derived.names, derived.units, strict=True)
    return _comment(words) + "\n" + _enumeration(capital, "DERIVED", rows)


def _row_words(model: StateSpaceModel) -> list[str]:
    words, at = ["Rows of the innovation:"], 0
    for sensor in model.sensors:
        units = [readable_unit(unit) for unit in sensor.unit_of_row]
        last = at + sensor.n_r - 1
        words.append(f"  {at} to {last}: {sensor.name}, {', '.join(units)}")
        at += sensor.n_r
    return words


def _constant_words(model: StateSpaceModel) -> list[str]:
    sensors = [stacked.sensor for stacked in constant_sensors(model)]
    detected = [
        f"The step finds from the inertial readings whether the body rests: {stacked.sensor.name}."
        for stacked in detected_sensors(model)
    ]
    if not sensors:
        return ["No sensor reads a constant.", *detected]
    return [*detected, "The step adds the readings of sensors that read a constant:"] + [
        f"  {sensor.name}: "
        + (f"once every {1 / sensor.rate_hz:g} s" if sensor.rate_hz else "at every measurement")
        for sensor in sensors
    ]


def _lags(capital: str, lags: Sequence[int]) -> str:
    if not lags:
        return ""
    words = [
        "Lags: places in `lagged_...` of the states so many samples before the newest, given all",
        "readings up to the newest. Samples are instants of measurements, of any sensor.",
    ]
    places = _enumeration(capital, "LAG", ((str(lag), "samples") for lag in lags))
    return f"\n{_comment(words)}\n{places}\n"


def _comment(lines: list[str]) -> str:
    return "/* " + "\n * ".join(map(in_comment, lines)) + " */"


def _statuses(capital: str) -> str:
    return "\n".join(
        f"#define {capital}_STATUS_{name} {member.value}u /* {SENTENCES[member]} */"
        for name, member in Status.__members__.items()
    )


def _flags(capital: str, model: StateSpaceModel) -> str:
    words = filled("watch.h", PREFIX=capital)
    bits = [
        f"#define {capital}_FLAG_{flag.name} {flag.value}u /* {_SAID_OF_A_SENSOR[flag]} */"
        for flag in Flag
    ]
    sensors = _enumeration(capital, "SENSOR", ((each.name, each.kind) for each in model.sensors))
    return "\n".join(["", words, *bits, sensors, ""])


def _member(field: Field, prefix: str, capital: str) -> str:
    sizes = _SIZES_OF.get(field.name)
    lengths = [f"{capital}_{size}" for size in sizes] if sizes else map(str, field.shape)
    array = f"[{' * '.join(lengths)}]" if field.shape else ""
    words = re.sub(r"\b(STATUS|DERIVED|FLAG|SENSOR)_", rf"{capital}_\1_", field.words)
    return f"    {field.c_type or f'{prefix}_real'} {field.name}{array}; /* {words} */"
