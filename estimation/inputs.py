"""Known inputs behind an instant's readings: one that is missing is as it was before.

An input holds until it is given anew, so a stream may tell only its changes. Before the first
measurement nothing is known of it: there it must be given.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from estimation.recording import Measurement
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel


def with_inputs(model: StateSpaceModel, before: Array | None, y: Array) -> Array:
    """Return a row (n_row,) whose inputs are all there; see `with_inputs` of engine.c.

    Parameters
    ----------
    before : (n_u,) the last known inputs; None where there are none

    Raises
    ------
    InputError
        If an input is missing that nothing is known of.
    """
    given = y[model.n_y :]
    if np.isfinite(given).all():
        return y
    held = given if before is None else np.where(np.isfinite(given), given, before)
    check_known(model, held)
    return np.concatenate([y[: model.n_y], held])


def without_readings(model: StateSpaceModel, y: Array) -> Array:
    """Return a row (n_row,) that has the inputs of another and no readings."""
    return np.concatenate([np.full(model.n_y, np.nan), y[model.n_y :]])


def check_known(model: StateSpaceModel, inputs: Array) -> None:
    """Raise `InputError` unless all inputs (n_u,) are numbers."""
    for name, value in zip(model.input_names, inputs, strict=True):
        if not np.isfinite(value):
            raise InputError(
                f"model {model.name}: input {name} is {value} and was not known before, "
                "expected a number: only a later one may be missing, it is held then"
            )


def rows_with_inputs(
    model: StateSpaceModel, rows: Iterable[Array], *, last: Array | None = None
) -> list[Array]:
    """Return rows (n_row,), one behind the other, whose inputs are all there.

    Parameters
    ----------
    last : (n_row,) the row before them; None where there is none
    """
    found: list[Array] = []
    for y in rows:
        last = with_inputs(model, None if last is None else last[model.n_y :], y)
        found.append(last)
    return found


def all_with_inputs(
    model: StateSpaceModel, measurements: Iterable[Measurement]
) -> tuple[Measurement, ...]:
    """Return measurements, one behind the other, whose inputs are all there."""
    given = tuple(measurements)
    rows = rows_with_inputs(model, [each.y for each in given])
    return tuple(Measurement(each.time_s, y) for each, y in zip(given, rows, strict=True))
