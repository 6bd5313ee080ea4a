"""The functions of the public header, around an estimator's loop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from codegen.constant_readings import constant_sensors, measured_columns
from codegen.estimate_fields import TOLD, Field, estimate_fields
from codegen.exportable import Exportable
from codegen.number_format import Precision
from codegen.structures import braces
from codegen.template import filled
from estimation.result import result_layout
from models.arrays import Array
from models.units import TIME_DIGITS

INSTANTS = ("time_s", "times", "at_time")
"""Names of blocks of the state and of arrays of the workspace that hold times."""
NEWEST = "(real)(state->newest_s - state->origin_s)"
REBASE = f"rebase(state, memory, {NEWEST});"
SINCE_ORIGIN = "(real)(time_s - state->origin_s)"
SNAPPED = f"snapped(state->memory[state->at], {SINCE_ORIGIN}, {NEWEST})"
TICK = 4
"""Roundings within which two times of a few bits are one."""


def interface(export: Exportable, start: Array, prefix: str, precision: Precision) -> str:
    """Return the C behind a loop.

    Parameters
    ----------
    start : the loop's flat state before the first measurement
    """
    model = export.model
    is_relative = precision.dtype is not np.float64
    result = result_layout(model, export.loop.lags)
    members = estimate_fields(result)
    first = next(member.name for member in members if member.c_type is None)
    constants = constant_sensors(model)
    entries = [f"{{{i}, {precision.number(float(start[i]))}}}" for i in np.flatnonzero(start)]
    return filled(
        "interface.c",
        prefix=prefix,
        PREFIX=prefix.upper(),
        entry=export.loop.entry,
        n_y=str(model.n_row),
        first=first,
        start=braces(entries),
        measured=braces([str(column) for column in measured_columns(model)]),
        time=f"late ? {SNAPPED} : {SINCE_ORIGIN}" if is_relative else "time_s",
        constants=_constants(export, precision) if constants else "",
        add_constants=_add_constants(prefix) if constants else "",
        check_inputs=_check_inputs(export) if model.n_u else "",
        call_constants="if (!late) add_constants(state, time_s, y);" if constants else "",
        rebase=_rebase(export, prefix, precision) if is_relative else "",
        call_rebase=REBASE if is_relative else "",
        **_watch(export, precision),
        numbers="\n".join(_numbers(members, is_relative)),
    )


def _watch(export: Exportable, precision: Precision) -> dict[str, str]:
    """Return the words of a step, and of what a watch begins with."""
    entry = export.loop.entry
    if export.watch is None:
        step = f"{entry}_step(own, state->memory[state->at], memory, time, y, told);"
        return {"step": step, "init_watch": "", "watch_start": ""}
    words = {"entry": entry, "kind": entry.capitalize(), "n_x": str(export.model.n_x)}
    values = braces([precision.number(float(x)) for x in export.watch.start])
    return {
        "step": filled("watched_step.c", **words).strip(),
        "init_watch": "\n    memcpy(state->watch, watch_start, sizeof watch_start);",
        "watch_start": f"\nstatic const real watch_start[] = {values};",
    }


def _numbers(members: Sequence[Field], is_relative: bool) -> list[str]:
    """Return what gives members of a type of their own their values, but for the newest time."""
    lines, at = [], 0
    for member in members:
        if member.c_type is None:
            continue
        size, told = math.prod(member.shape), f"({member.c_type})estimate->{TOLD}"
        if member.c_type == "double" and is_relative:
            told = f"state->origin_s + {told}"
        if member.shape:
            lines += [
                f"    for (integer i = 0; i < {size}; i++)",
                f"        estimate->{member.name}[i] = {told}[{at} + i];",
            ]
        elif member.name != "time_s":
            lines.append(f"    estimate->{member.name} = {told}[{at}];")
        at += size
    return lines


def _check_inputs(export: Exportable) -> str:
    """Return what refuses a measurement without an input that was not known before."""
    model, at = export.model, export.loop.memory.slices["inputs"].start
    n_given = len(measured_columns(model)) - model.n_u
    return (
        f"for (integer i = 0; i < {model.n_u}; i++)\n"
        f"        if (!isfinite(readings[{n_given} + i])\n"
        f"            && !isfinite(state->memory[state->at][{at} + i])) return -1;\n"
    )


def _add_constants(prefix: str) -> str:
    return filled("add_constants.c", prefix=prefix, tick=repr(0.5 * 10**-TIME_DIGITS)) + "\n"


def _constants(export: Exportable, precision: Precision) -> str:
    """Return the table of sensors that read a constant."""
    sensors = constant_sensors(export.model)
    most = max(stacked.sensor.n_y for stacked in sensors)
    rows = []
    for stacked in sensors:
        values = [precision.number(float(x)) for x in np.asarray(stacked.sensor.constant_reading)]
        rate = stacked.sensor.rate_hz or 0.0
        rows.append(
            f"{{{stacked.column}, {stacked.sensor.n_y}, {float(rate)!r}, {{{', '.join(values)}}}}}"
        )
    return (
        "/* Sensors that read a constant; a rate of 0 Hz is every measurement's. */\n"
        "static const struct { integer column, n; double rate_hz; "
        f"real value[{most}]; }} constants[] = {braces(rows)};\n"
    )


def _rebase(export: Exportable, prefix: str, precision: Precision) -> str:
    """Return what keeps times of a few bits near zero."""
    memory, loop = export.loop.memory, export.loop
    first, *_ = (memory.slices[name] for name in INSTANTS if name in memory.shapes)
    spans = {
        f"memory[{memory.slices[name].start} + i]": math.prod(memory.shapes[name])
        for name in INSTANTS
        if name in memory.shapes
    }
    for group, values in loop.fields.items():
        if isinstance(values, Mapping):
            spans |= {
                f"{loop.entry}_{group}_{name}[i]": values[name].size
                for name in INSTANTS
                if name in values
            }
    for part in export.watch.instants if export.watch else ():
        spans[f"state->watch[{part.start} + i]"] = part.stop - part.start
    shifts = [
        f"    for (integer i = 0; i < {size}; i++) {entry} -= oldest;"
        for entry, size in spans.items()
    ]
    return filled(
        "rebase.c",
        prefix=prefix,
        first=str(first.start),
        n_times=str(first.stop - first.start),
        tick=precision.number(TICK * float(np.finfo(precision.dtype).eps)),
        shifts="\n".join(shifts),
    )
