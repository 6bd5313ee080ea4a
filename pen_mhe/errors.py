"""Errors of a run against the truth, in the units people read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from estimation.estimate import EstimateHistory
from estimation.observability import Verdict
from estimation.outputs import outputs_of
from estimation.recording import Truth
from models.arrays import Array
from models.state_space import StateSpaceModel

ERROR_COLUMNS: Mapping[str, tuple[tuple[str, ...], float]] = MappingProxyType(
    {
        "tip_mm": (("tip_x_m", "tip_y_m", "tip_z_m"), 1e3),
        "azimuth_deg": (("azimuth_rad",), 180 / math.pi),
        "elevation_deg": (("elevation_rad",), 180 / math.pi),
        "spin_deg": (("spin_rad",), 180 / math.pi),
        "rates_deg_s": (
            (
                *("azimuth_rate_rad_s", "elevation_rate_rad_s", "spin_rate_rad_s"),
                *("body_rate_x_rad_s", "body_rate_y_rad_s", "body_rate_z_rad_s"),
            ),
            180 / math.pi,
        ),
    }
)
"""Column of an error table → (states, factor from SI)."""


NOT_OBSERVABLE = "not observable"
"""What stands in the place of an error that would only show the prior."""


def state_errors(model: StateSpaceModel, history: EstimateHistory, truth: Truth) -> Array:
    """Return estimate minus truth (n, n_o) at the estimates' instants, of `history.names`.

    Names that the truth does not name have NaN.

    Raises
    ------
    InputError
        If an estimate's instant is not among the truth's.
    """
    return replace(history, difference=model.difference).errors(truth)


def root_mean_square(
    names: Sequence[str], errors: Array, columns: Mapping[str, tuple[tuple[str, ...], float]]
) -> dict[str, float]:
    """Return the RMS error per column; the norm over its states where it has several.

    Instants without truth do not count; a column none of whose states is among the names,
    or without any truth, is left out.

    Parameters
    ----------
    names : (n_o,) of the columns of `errors`
    errors : (n, n_o)
    columns : as `ERROR_COLUMNS`
    """
    squared = squared_errors(names, errors, columns)
    means = {column: float(known.mean()) for column, known in squared.items() if len(known)}
    return {column: rms_of(mean, columns[column][1]) for column, mean in means.items()}


def squared_errors(
    names: Sequence[str], errors: Array, columns: Mapping[str, tuple[tuple[str, ...], float]]
) -> dict[str, Array]:
    """Return by column the squared errors of the instants with truth; see `root_mean_square`."""
    found = {}
    for column, (states, _) in columns.items():
        index = [names.index(state) for state in states if state in names]
        if index:
            squared = (errors[:, index] ** 2).sum(axis=1)
            found[column] = squared[~np.isnan(squared)]
    return found


def rms_of(mean_square: float, factor: float) -> float:
    """Return an RMS error in the unit of a column, by its factor, of the mean square in SI."""
    return float(np.sqrt(mean_square) * factor)


def known_columns(
    names: Sequence[str], true_names: Sequence[str]
) -> dict[str, tuple[tuple[str, ...], float]]:
    """Return the rows of `ERROR_COLUMNS` all of whose outputs a truth names."""
    return {
        column: entry
        for column, entry in ERROR_COLUMNS.items()
        if set(entry[0]) & set(names) <= set(true_names)
    }


def rms_errors(
    model: StateSpaceModel, history: EstimateHistory, truth: Truth, *, after_s: float = 0.0
) -> dict[str, float]:
    """Return the RMS error per column of `ERROR_COLUMNS` that the model and the truth have.

    Parameters
    ----------
    after_s : from the first estimate on, s: what comes earlier does not count

    Raises
    ------
    InputError
        If an estimate's instant is not among the truth's.
    """
    errors = state_errors(model, history, truth)
    return root_mean_square(
        history.names, errors[history.time_s >= history.time_s[0] + after_s], ERROR_COLUMNS
    )


def seen_only(
    model: StateSpaceModel, values: Mapping[str, float], verdict: Verdict
) -> dict[str, float | str]:
    """Return values by column of `ERROR_COLUMNS`, `NOT_OBSERVABLE` where a state is not seen."""
    states = {
        column: [name for name in ERROR_COLUMNS[column][0] if name in outputs_of(model).names]
        for column in values
    }
    return {
        column: value if all(verdict.sees(name) for name in states[column]) else NOT_OBSERVABLE
        for column, value in values.items()
    }
