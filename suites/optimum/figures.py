"""How far windows that end in one minimum are apart, over how many of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.figures.figure import Figure, Line, Panel
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from models.arrays import Array
from suites.optimum.kinds import KINDS
from suites.optimum.quantities import APART, COSTS, NEAR, NEWEST
from suites.optimum.run import COST_LIMIT, NEWEST_LIMIT

DISTANCES = np.geomspace(1e-16, 1e-4, 241)
LIMIT = "allowed"


def figures(results: Results) -> Sequence[Figure]:
    """Return the figure, where there are windows in one minimum."""
    panels = [
        _panel(results, NEWEST, "newest states", "standard deviations", NEWEST_LIMIT),
        _panel(results, COSTS, "costs", "relative", COST_LIMIT),
    ]
    if not any(len(panel.lines) > 1 for panel in panels):
        return []
    return [
        Figure(
            "optimum-apart",
            "How far mhe and IPOPT end from each other",
            "Windows that both solve into one minimum, from the same start. A standard deviation "
            "is the newest state's own, as the window claims it; of a window counts the state "
            "that is farthest.",
            panels,
            columns=2,
        )
    ]


def _panel(results: Results, quantity: str, what: str, unit: str, limit: float) -> Panel:
    lines = [
        Line(kind.label, DISTANCES, shares)
        for name, kind in KINDS.items()
        if (shares := _shares(results, name, quantity)) is not None
    ]
    lines.append(Line(LIMIT, np.full(2, limit), np.array([0.0, 100.0]), style="dashed"))
    return Panel(what, f"farther apart than ({unit})", "share of windows (%)", lines, x_log=True)


def _shares(results: Results, case: str, quantity: str) -> Array | None:
    """Return how many % of a kind's windows are farther apart than each of `DISTANCES`."""
    rows = results.select(status=OK, case=case)
    there = rows[rows["quantity"].isin([NEAR, APART]) & (rows["bias"] == 1)]["seed"]
    apart = rows[(rows["quantity"] == quantity) & rows["seed"].isin(there)]["rmse"]
    if not len(apart):
        return None
    return 100 * (apart.to_numpy(dtype=float) > DISTANCES[:, None]).mean(axis=1)
