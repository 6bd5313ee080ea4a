"""What is judged of an estimate of a pen whose true motion is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Quantity
from estimation.estimate import EstimateHistory
from estimation.recording import Truth
from models.arrays import Array
from models.state_space import StateSpaceModel
from pen_mhe.errors import ERROR_COLUMNS, state_errors

SETTLING_S = 1.0
"""Begin of a run that errors leave out."""

UNITS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "tip_mm": ("tip", "mm"),
        "azimuth_deg": ("azimuth", "deg"),
        "elevation_deg": ("elevation", "deg"),
        "spin_deg": ("spin", "deg"),
        "rates_deg_s": ("rates", "deg/s"),
    }
)
"""Column of `pen_mhe.errors.ERROR_COLUMNS` → quantity and unit."""


def pen_quantities(
    model: StateSpaceModel,
    history: EstimateHistory,
    truth: Truth,
    seen: Mapping[str, bool],
    *,
    settling_s: float = SETTLING_S,
) -> list[Quantity]:
    """Return the errors of a pen's tip, angles and rates after `settling_s`.

    Of the rates, those that model and truth share: of the body, or of the angles.

    Parameters
    ----------
    seen : output → whether the sensors show it; a quantity is observable where all of its
        outputs are
    """
    later: Array = history.time_s - history.time_s[0] >= settling_s
    found = []
    for part in _parts(model, history, truth):
        observable = all(seen[name] for name in part.names)
        claims = part.std[later]
        found.append(
            Quantity.of_errors(
                part.quantity, part.unit, part.errors[later], observable, claimed=claims
            )
        )
    return found


def quantities_at(
    model: StateSpaceModel, history: EstimateHistory, truth: Truth, at_s: Sequence[float]
) -> list[Quantity]:
    """Return the errors of a pen at some times after the first estimate: ``tip at 0.5 s``."""
    elapsed = history.time_s - history.time_s[0]
    found = []
    for part in _parts(model, history, truth):
        for at in at_s:
            row = [int(np.argmin(np.abs(elapsed - at)))]
            name = at_time(part.quantity, at)
            errors, claims = part.errors[row], part.std[row]
            found.append(Quantity.of_errors(name, part.unit, errors, claimed=claims))
    return found


def at_time(quantity: str, at_s: float) -> str:
    """Return the name of a quantity at a time."""
    return f"{quantity} at {at_s:g} s"


@dataclass(frozen=True, eq=False)
class _Part:
    """What is known of a quantity: its outputs, errors and claimed deviations, each (n, k)."""

    quantity: str
    unit: str
    names: tuple[str, ...]
    errors: Array
    std: Array


def _parts(model: StateSpaceModel, history: EstimateHistory, truth: Truth) -> list[_Part]:
    errors, std = state_errors(model, history, truth), history.values_std
    found = []
    for column, (quantity, unit) in UNITS.items():
        names, factor = ERROR_COLUMNS[column]
        known = tuple(name for name in names if name in history.names and name in truth.names)
        if known:
            index = [history.index(name) for name in known]
            of_run, claims = (factor * values[:, index] for values in (errors, std))
            found.append(_Part(quantity, unit, known, of_run, claims))
    return found
