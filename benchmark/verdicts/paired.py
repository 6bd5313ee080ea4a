"""One estimator against another on the same recordings, quantity by quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmark.tasks.task import OK
from benchmark.verdicts.bootstrap import Interval, Strata, interval

if TYPE_CHECKING:
    import pandas as pd

BETTER, WORSE, EQUAL = "better", "worse", "no difference shown"
SAME, SAME_FRACTION = "the same within 1 %", 0.01
"""A difference whose whole interval is a smaller part of the error matters to nobody."""

GROUP = ["suite", "sensors", "quantity", "unit"]


def counting(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of runs that count: `OK`, and the quantity observable and finite."""
    return rows[(rows["status"] == OK) & rows["observable"].eq(True) & np.isfinite(rows["rmse"])]


def paired(rows: pd.DataFrame, estimator: str = "ekf", other: str = "mhe") -> pd.DataFrame:
    """Compare the RMSE of two estimators on the runs that both have.

    A run counts where both do, see `counting`.

    Returns
    -------
    One row per suite, sensors and quantity: ``suite``, ``sensors``, ``quantity``, ``unit``;
    the mean RMSE of each of the two under its name; ``difference``, ``low``, ``high``: mean
    of the other's minus the first's with its 95 % bootstrap interval; ``pairs``;
    ``verdict``: whether the other one is `BETTER`, `WORSE`, `SAME` or `EQUAL`
    """
    import pandas as pd  # slow to import, for tables only

    seen = counting(rows)
    keys = [*GROUP, "case", "seed"]
    first, second = (
        seen[seen["estimator"] == name][[*keys, "rmse"]].rename(columns={"rmse": name})
        for name in (estimator, other)
    )
    both = first.merge(second, on=keys).sort_values(keys, kind="stable")
    found = []
    for key, part in both.groupby(GROUP, sort=False):
        difference = (part[other] - part[estimator]).to_numpy(dtype=float)
        strata = Strata(np.asarray(part.groupby("case", sort=False).ngroup(), dtype=np.int64))
        of = interval(
            "/".join(map(str, key)),
            strata,
            lambda index, d=difference: np.mean(d[index], axis=-1),  # type: ignore[misc]
            len(difference),
        )
        found.append(
            {
                **dict(zip(GROUP, key, strict=True)),
                estimator: float(part[estimator].mean()),
                other: float(part[other].mean()),
                "difference": of.figure,
                "low": of.low,
                "high": of.high,
                "pairs": len(part),
                "verdict": _verdict(of, float(part[estimator].mean())),
            }
        )
    columns = [*GROUP, estimator, other, "difference", "low", "high", "pairs", "verdict"]
    return pd.DataFrame(found, columns=columns)


def _verdict(difference: Interval, error: float) -> str:
    """Return what the interval of a difference says, beside the size of the error itself."""
    if max(abs(difference.low), abs(difference.high)) <= SAME_FRACTION * error:
        return SAME
    return BETTER if difference.high < 0 else WORSE if difference.low > 0 else EQUAL
