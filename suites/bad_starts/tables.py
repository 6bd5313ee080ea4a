"""The tables of all cases: medians and 90th percentiles over the runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from benchmark.figures.figure import Table
from benchmark.tasks.results import Results
from models.arrays import Array
from pen_mhe.estimators import ESTIMATORS
from suites.bad_starts.cases import CASES, KNOWLEDGE
from suites.bad_starts.quantities import (
    AT_S,
    END,
    FIRST_RATES,
    HONEST,
    NEAR,
    WITHIN_DEG,
    WITHIN_STD,
    up_after,
)
from suites.bad_starts.run import FIRST_S

if TYPE_CHECKING:
    import pandas as pd

HEAD = ("Case", "Told", "Start wrong by (deg)")
Values = Mapping[str, Array]
"""Quantity → its figure in every run (n,) of a case by an estimator."""


def _median_and_p90(values: Array, *, digits: str = ".2g") -> str:
    median, p90 = np.quantile(values, [0.5, 0.9])
    return f"{median:{digits}} ({p90:{digits}})"


def _over_time(values: Values) -> str:
    there = [values[name] for name in map(up_after, AT_S) if name in values]
    return "; ".join(map(_median_and_p90, there))


CELLS: Mapping[str, Callable[[Values], str]] = MappingProxyType(
    {
        f"Up: error after {', '.join(f'{t:g}' for t in AT_S)} s (deg), median (90 %)": _over_time,
        "Body rates: RMS error of the first second (rad/s), median (90 %)": (
            lambda values: _median_and_p90(values[FIRST_RATES])
        ),
        f"After {FIRST_S:g} s: runs within {WITHIN_DEG:g} deg, within {WITHIN_STD:g} claimed "
        "deviations": lambda values: f"{values[NEAR].mean():.0%}, {values[HONEST].mean():.0%}",
        "End error over its claimed deviation, median (honest: 1.18; without spin 0.67)": (
            lambda values: f"{np.median(values[END]):.2g}"
        ),
    }
)
"""Title → the cell of a case and an estimator."""


def tables(results: Results) -> Sequence[Table]:
    """Return a table per entry of `CELLS`, a row per case that was run."""
    rows = results.rows[results.rows["quantity"] != ""]
    found = {key: _values(part) for key, part in rows.groupby(["case", "estimator"], observed=True)}
    cases = [name for name in CASES if any(case == name for case, _ in found)]
    estimators = [name for name in ESTIMATORS if any(ran == name for _, ran in found)]
    runs = max((len(values[END]) for values in found.values()), default=0)
    caption = f"{runs} runs of each case by each estimator."
    head = (*HEAD, *estimators)

    def row(case: str, cell: Callable[[Values], str]) -> tuple[str, ...]:
        keys = [(case, name) for name in estimators]
        return (*_described(case), *(cell(found[key]) if key in found else "" for key in keys))

    return [
        (title, caption, head, [row(case, cell) for case in cases])
        for title, cell in CELLS.items()
        if cases
    ]


def _described(name: str) -> tuple[str, str, str]:
    case = CASES[name]
    return case.label, KNOWLEDGE[case.knowledge].label, case.start


def _values(rows: pd.DataFrame) -> dict[str, Array]:
    """Return the figures of a case and estimator: RMS over a time, or what there is one of."""
    return {
        str(name): part["rmse"].to_numpy(dtype=float)
        for name, part in rows.groupby("quantity", observed=True)
    }
