"""Which choices of sensors the seeds of a run do not tell apart from the best one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmark.report.choice import worst
from benchmark.report.matrix import Cell, Matrix
from benchmark.verdicts.bootstrap import LEVEL
from benchmark.verdicts.paired import counting


@dataclass(frozen=True)
class Choice:
    """A choice of sensors with the reliable estimator of the smallest median."""

    sensors: str
    estimator: str
    cell: Cell


def tied(matrix: Matrix, best: Choice, others: Sequence[Choice]) -> Iterator[Choice]:
    """Yield those of the other choices that are not surely worse than the best one.

    The logarithm of the ratio of both RMSEs, seed by seed, has a mean with a lower limit by
    Student's distribution; where it is above zero the other one is worse. The limits of all the
    others hold together with 95 % (Bonferroni), and so what is truly the best is the best here or
    among those that are yielded, although the best here was found from the same seeds. Bootstrap
    intervals, as of estimators, are too short for it: of five seeds they hold with 84 %, each
    (`benchmark.verdicts.coverage`). A choice that lost a seed is worse.

    Source: J. C. Hsu, "Simultaneous confidence intervals for all distances from the 'best'",
    Ann. Statist. 9 (1981), 1026-1034.
    """
    for other in others:
        is_lost = math.isinf(worst(other.cell)) and not math.isinf(worst(best.cell))
        if not is_lost and not _low(_log_ratios(matrix, best, other), len(others)) > 0:
            yield other


def _log_ratios(matrix: Matrix, best: Choice, other: Choice) -> np.ndarray:
    """Return log(RMSE of the other / RMSE of the best), (n,), of the seeds that both have."""
    of = counting(matrix.rows[matrix.rows["quantity"] == matrix.quantity])
    first, second = (
        of[(of["sensors"] == choice.sensors) & (of["estimator"] == choice.estimator)].set_index(
            ["case", "seed"]
        )["rmse"]
        for choice in (best, other)
    )
    seeds = first.index.intersection(second.index)
    least = np.finfo(float).tiny
    return np.log(np.maximum(second[seeds], least)) - np.log(np.maximum(first[seeds], least))


def _low(values: np.ndarray, together: int) -> float:
    """Return the lower limit of a mean, of so many; -inf of a single value."""
    from scipy.stats import t  # slow to import, for reports only

    n = len(values)
    if n < 2:
        return -math.inf
    tail = (1 - LEVEL) / together
    return float(np.mean(values) - t.isf(tail, n - 1) * np.std(values, ddof=1) / math.sqrt(n))
