"""What no reading of a run has shown: where its estimate only repeats what was known before.

Place and attitude are not observable in a row whose standard deviation is above
`OBSERVABLE_FRACTION` of the prior's, and above what is of use to anyone: an estimator's own claims
say so, row by row. Nor is the place of a tip that only the writing area holds, which is no reading.
Along a known truth `pen_mhe.sensor_verdict` judges more strictly.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from estimation.history import EstimateHistory
from estimation.information_bound import OBSERVABLE_FRACTION
from estimation.outputs import output_jacobian, outputs_of
from models.state_space import StateSpaceModel

TIP = ("tip_x_m", "tip_y_m", "tip_z_m")
USELESS: Mapping[str, float] = MappingProxyType(
    {
        **dict.fromkeys(TIP, 0.02),
        **dict.fromkeys(("azimuth_rad", "elevation_rad", "spin_rad"), float(np.radians(10.0))),
    }
)
"""Quantity → standard deviation, SI, below which it is of use, however it is known."""
COLUMN = "not_observable"
MOSTLY = 0.5
"""Part of a run's rows from which on a figure takes a quantity for not observable."""
WORDS: Mapping[str, str] = MappingProxyType(
    {**dict.fromkeys(TIP, "tip"), "azimuth_rad": "azimuth", "elevation_rad": "elevation",
     "spin_rad": "spin"}
)  # fmt: skip
"""Quantity → what a sentence calls it."""


@lru_cache(maxsize=16)
def limits(model: StateSpaceModel) -> Mapping[str, float]:
    """Return the deviation of each quantity above which it is not observable, SI.

    Below zero for one that never is.
    """
    names, mean = outputs_of(model).names, model.prior.mean
    J = output_jacobian(model)(mean).full()
    prior = np.sqrt(np.einsum("ij,jk,ik->i", J, model.prior.covariance, J))
    found = {
        name: max(OBSERVABLE_FRACTION * float(prior[names.index(name)]), useful)
        for name, useful in USELESS.items()
        if name in names
    }
    touches = any(sensor.touched_height is not None for sensor in model.sensors)
    if any(sensor.constant_reading is not None for sensor in model.sensors):
        found |= dict.fromkeys((n for n in TIP[: 2 if touches else 3] if n in names), -1.0)
    return found


def unseen_rows(model: StateSpaceModel, history: EstimateHistory) -> dict[str, NDArray[np.bool_]]:
    """Return quantity → in which rows (n,) no reading shows it."""
    return {
        name: history.std_of(name) > limit
        for name, limit in limits(model).items()
        if name in history.names
    }


def unseen(model: StateSpaceModel, history: EstimateHistory) -> frozenset[str]:
    """Return the quantities that are not observable in most rows of a run."""
    parts = UnseenInParts(model)
    parts.add(history)
    return parts.result()


class UnseenInParts:
    """What is not observable in most rows of a run that comes in parts."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._model, self._rows = model, 0
        self._counts: Counter[str] = Counter()

    def add(self, history: EstimateHistory) -> None:
        """Take the next rows."""
        self._rows += len(history)
        for name, rows in unseen_rows(self._model, history).items():
            self._counts[name] += int(rows.sum())

    def result(self) -> frozenset[str]:
        """Return the quantities."""
        return frozenset(n for n, count in self._counts.items() if count > MOSTLY * self._rows)


def unseen_words(names: Sequence[str] | frozenset[str]) -> str:
    """Return quantities in words: ``tip and azimuth``; nothing for none."""
    found = list(dict.fromkeys(WORDS[name] for name in USELESS if name in names))
    return " and ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)


def output_table(model: StateSpaceModel, history: EstimateHistory) -> pd.DataFrame:
    """Return the table of a history with what is not observable in each row.

    Behind ``status`` stands `COLUMN`: ``tip_x_m+tip_y_m+tip_z_m+azimuth_rad``, empty where all is.
    """
    table = history.to_pandas()
    labels = np.full(len(history), "", dtype=object)
    for name, rows in unseen_rows(model, history).items():
        labels[rows] += np.where(labels[rows] == "", name, f"+{name}").astype(object)
    table.insert(list(table.columns).index("status") + 1, COLUMN, labels)
    return table
