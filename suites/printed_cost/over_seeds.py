"""What the seeds of a model at a speed have in common: means and spreads of their errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from suites.printed_cost.run import CASES, CONFIGURATIONS, MODELS


@dataclass(frozen=True)
class OverSeeds:
    """A model at a speed with some sensors.

    Parameters
    ----------
    case, sensors, model : as of its tasks
    seeds : number of them
    rms : quantity → root mean square over all seeds and instants
    mean, spread : observable quantity → mean of the seeds' RMS errors, and their standard
        deviation; NaN of a single one
    """

    case: str
    sensors: str
    model: str
    seeds: int
    rms: Mapping[str, float]
    mean: Mapping[str, float]
    spread: Mapping[str, float]


def over_seeds(results: Results) -> Sequence[OverSeeds]:
    """Return every model at every speed that there are results of, in the order of the tasks."""
    rows = results.select(status=OK).astype(
        dict.fromkeys(("case", "sensors", "estimator", "quantity"), str)
    )
    parts = dict(list(rows.groupby(["case", "sensors", "estimator"])))
    found = []
    for key in product(CASES, CONFIGURATIONS, MODELS):
        if (part := parts.get(key)) is None:
            continue
        rmse = part.pivot(index="seed", columns="quantity", values="rmse")
        seen = part[part["observable"].eq(True)]["quantity"].unique()
        found.append(
            OverSeeds(
                *key,
                len(rmse),
                {str(name): float(np.sqrt((rmse[name] ** 2).mean())) for name in rmse},
                {str(name): float(rmse[name].mean()) for name in seen},
                {str(name): float(rmse[name].std(ddof=1)) for name in seen},
            )
        )
    return found
