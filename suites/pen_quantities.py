"""What is judged of an estimate of a pen whose true motion is known."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

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
    errors, std = state_errors(model, history, truth), history.values_std
    later: Array = history.time_s - history.time_s[0] >= settling_s
    found = []
    for column, (quantity, unit) in UNITS.items():
        names, factor = ERROR_COLUMNS[column]
        known = [name for name in names if name in history.names and name in truth.names]
        if known:
            index = [history.index(name) for name in known]
            of_run, claims = (factor * values[later][:, index] for values in (errors, std))
            observable = all(seen[name] for name in known)
            found.append(Quantity.of_errors(quantity, unit, of_run, observable, claimed=claims))
    return found
