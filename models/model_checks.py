"""Whether the parts of a state-space model fit together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from models.errors import InputError

if TYPE_CHECKING:
    from models.state_space import StateSpaceModel


def check_model(model: StateSpaceModel) -> None:
    """Raise `InputError` with the first part whose shape or value does not fit."""
    n_x = model.n_x
    expected = {
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
    }
    if model.reach is not None:
        expected["reach"] = (model.reach.size, n_x)
    for sensor in model.sensors:
        expected[f"{sensor.name}: h"] = (sensor.h.numel_out(0), sensor.n_y)
        expected[f"{sensor.name}: residual"] = (sensor.residual.numel_out(0), sensor.n_r)
        expected[f"{sensor.name}: h's state"] = (sensor.h.numel_in(0), n_x)
        expected[f"{sensor.name}: residual's reading"] = (sensor.residual.numel_in(0), sensor.n_y)
        expected[f"{sensor.name}: residual's state"] = (sensor.residual.numel_in(1), n_x)
        expected[f"{sensor.name}: unit_of_axis"] = (len(sensor.unit_of_axis), sensor.n_y)
        expected[f"{sensor.name}: unit_of_row"] = (len(sensor.unit_of_row), sensor.n_r)
        if sensor.constant_reading is not None:
            size = sensor.constant_reading.size
            expected[f"{sensor.name}: constant_reading"] = (size, sensor.n_y)
        if not (np.isfinite(sensor.noise_std) & (sensor.noise_std > 0)).all():
            raise InputError(
                f"model {model.name}: noise_std of {sensor.name} is {sensor.noise_std}, "
                "expected positive numbers"
            )
    for what, (size, wanted) in expected.items():
        if size != wanted:
            raise InputError(f"model {model.name}: {what} has {size} entries, expected {wanted}")
    if model.conditions is not None:
        conditions, rows = model.conditions, (int(model.inequality.numel_out(0)), model.n_y)
        if conditions.shape != rows or conditions.dtype != np.bool_:
            raise InputError(
                f"model {model.name}: conditions have shape {conditions.shape} of "
                f"{conditions.dtype}, expected {rows} of bool: rows of the inequality, readings"
            )
    mean, covariance = model.prior.mean, model.prior.covariance
    for what, array, shape in (("mean", mean, (n_x,)), ("covariance", covariance, (n_x, n_x))):
        if array.shape != shape:
            raise InputError(
                f"model {model.name}: the prior {what} has shape {array.shape}, expected {shape}"
            )
        if not np.isfinite(array).all():
            raise InputError(
                f"model {model.name}: the prior {what} has entries that are not finite"
            )
    asymmetry = np.abs(covariance - covariance.T)
    if (asymmetry > 1e-9 * np.abs(covariance).max()).any():
        raise InputError(
            f"model {model.name}: the prior covariance is not symmetric, expected P = Pᵀ"
        )
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise InputError(
            f"model {model.name}: the prior covariance is not positive definite, "
            "expected positive variances and correlations between -1 and 1"
        ) from None
