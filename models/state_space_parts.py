"""Parts of a state-space model: whether they fit together, and a row of what an instant has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array, numbers
from models.errors import InputError
from models.model_checks import check_conditions, check_prior, check_sizes, input_sizes
from models.names import unknown
from models.own_arguments import called, check_arguments, check_symbols


def check_model(model: Any) -> None:
    """Raise `InputError` unless the parts of a `models.state_space.StateSpaceModel` fit."""
    n_x = model.n_x
    sizes = {
        "state_units": (len(model.state_units), n_x),
        "f's state": (model.f.numel_in(0), n_x),
        "f's step": (model.f.numel_in(2), 1),
        "f's result": (model.f.numel_out(0), n_x),
        "prior mean": (model.prior.mean.size, n_x),
        "prior covariance": (model.prior.covariance.size, n_x * n_x),
        "lower": (model.lower.size, n_x),
        "upper": (model.upper.size, n_x),
        "retract": (model.retract.numel_out(0), n_x),
        "difference": (model.difference.numel_out(0), n_x),
        "inequality": (model.inequality.numel_in(0), n_x),
        "regularity": (model.regularity.numel_out(0), 1),
        "input_units": (len(model.input_units), model.n_u),
        **input_sizes("f", model.f, 3, (model.n_u, model.n_u) if model.n_u else ()),
    }
    if model.reach is not None:
        sizes["reach"] = (model.reach.size, n_x)
    check_sizes(model.name, sizes, model.sensors, n_x, n_u=model.n_u)
    if model.conditions is not None:
        rows = (int(model.inequality.numel_out(0)), model.n_y)
        check_conditions(model.name, model.conditions, rows)
    check_prior(model.name, model.prior, n_x)


def with_rows(model: Any, inequality: Callable[[ca.SX], ca.SX]) -> ca.Function:
    """Return a model's inequality with rows more; `InputError` where they are no expressions."""
    what, x = f"model {model.name}: an inequality", ca.SX.sym("x", model.n_x)
    check_arguments(what, inequality, ("x",))
    added = ca.vertcat(called(what, inequality, (x,)))
    rows = ca.vertcat(model.inequality(x), added)
    check_symbols(what, rows, {"x": x})
    return ca.Function("inequality", [x], [rows], ["x"], ["g"])


def stacked_row(model: Any, readings: Mapping[str, Array], inputs: Mapping[str, float]) -> Array:
    """Return a row (n_row,) of readings and inputs; see `stack` of the model.

    Raises
    ------
    InputError
        If a reading has another shape, or a sensor or an input is unknown.
    """
    parts, names = [], [sensor.name for sensor in model.sensors]
    for name in readings:
        if name not in names:
            raise unknown(f"model {model.name}: sensor", name, names)
    for sensor in model.sensors:
        given = readings.get(sensor.name, np.full(sensor.n_y, np.nan))
        value = numbers(given, f"reading of {sensor.name}", f"({sensor.n_y},) numbers")
        value = value.reshape(sensor.n_y) if value.shape == () and sensor.n_y == 1 else value
        if value.shape != (sensor.n_y,):
            raise InputError(
                f"reading of {sensor.name} has shape {value.shape}, expected ({sensor.n_y},)"
            )
        parts.append(value)
    for name in inputs:
        if name not in model.input_names:
            raise unknown(f"model {model.name}: input", name, model.input_names)
    for name in model.input_names:
        value = numbers(inputs.get(name, np.nan), f"input {name}", "a number")
        if value.shape != ():
            raise InputError(f"input {name} has shape {value.shape}, expected a number")
        parts.append(value.reshape(1))
    return np.concatenate([np.zeros(0), *parts])
