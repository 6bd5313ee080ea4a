"""Counts and worst distances by sensors and by kind, and every window that differs."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from benchmark.figures.figure import Table
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from suites.optimum.cases import window_bodies, window_key
from suites.optimum.kinds import KINDS
from suites.optimum.quantities import APART, COST, COSTS, COUNTED, LEFT, NEAR, NEWEST, RUNS
from suites.optimum.run import ABOVE, BELOW, COST_LIMIT, IPOPT_FAILED, NEWEST_LIMIT

if TYPE_CHECKING:
    import pandas as pd

OF_WINDOW = ["case", "sensors", "seed", "reason"]
PARTS = ("windows", NEAR, APART, ABOVE, BELOW, IPOPT_FAILED, "newest apart, σ", "costs apart")
LISTED = (
    *("seed", "sensors", "windows", "N", "cost", "costs apart"),
    *("newest apart, σ", "mhe has left, σ", "why"),
)
LISTS: Mapping[str, str] = {
    APART: "In IPOPT's minimum, but farther apart than they may be",
    ABOVE: "Above IPOPT's minimum",
    BELOW: "Below IPOPT's minimum",
    IPOPT_FAILED: "IPOPT failed",
}
"""Quantity that counts windows → title of the table of these windows."""


def windows(results: Results) -> pd.DataFrame:
    """Return a row per window: `OF_WINDOW`, and its figure of each quantity."""
    rows = results.select(status=OK).astype({"case": str, "sensors": str, "reason": str})
    figures = rows.pivot(index=OF_WINDOW, columns="quantity", values="bias")
    return figures.reset_index().sort_values("seed", kind="stable")


def tables(results: Results) -> Sequence[Table]:
    """Return the counts, and a list of each kind of window that differs."""
    table = windows(results)
    if not len(table):
        return []
    caption = (
        f"mhe against IPOPT from the same start, {len(table)} windows; in {_carried_on(table)} of "
        "them IPOPT was carried on with the exact Hessian. The largest distances are those in "
        "one minimum."
    )
    by_kind = {name: kind.label for name, kind in KINDS.items()}
    parts = (
        ("sensors", {name: name for name in window_bodies()}),
        ("case", by_kind),
    )
    counted = [
        (f"Windows by {column}", caption, (column, *PARTS), _counted(table, column, labels))
        for column, labels in parts
    ]
    listed = [
        (title, _limits(), LISTED, [_listed(row) for row in there.to_dict("records")])
        for name, title in LISTS.items()
        if len(there := table[table[name] == 1])
    ]
    return [*counted, *listed]


def _limits() -> str:
    return (
        f"Allowed are {NEWEST_LIMIT:g} standard deviations between newest states and "
        f"{COST_LIMIT:g} of the cost."
    )


def _carried_on(table: pd.DataFrame) -> int:
    return int((table[RUNS] > 1).sum())


def _counted(table: pd.DataFrame, column: str, labels: Mapping[str, str]) -> list[tuple[str, ...]]:
    parts = {label: table[table[column] == name] for name, label in labels.items()}
    return [_part(label, part) for label, part in {**parts, "all": table}.items() if len(part)]


def _part(label: str, part: pd.DataFrame) -> tuple[str, ...]:
    counts = [str(int(part[name].sum())) for name in PARTS if name in COUNTED]
    same = part[(part[NEAR] == 1) | (part[APART] == 1)]
    worst = [f"{same[name].abs().max():.1e}" if len(same) else "" for name in (NEWEST, COSTS)]
    return label, str(len(part)), *counts, *worst


def _listed(row: Mapping[Hashable, Any]) -> tuple[str, ...]:
    seed = int(row["seed"])
    return (
        str(seed),
        str(row["sensors"]),
        KINDS[str(row["case"])].label,
        str(window_key(seed).horizon),
        f"{row[COST]:.6g}",
        f"{row[COSTS]:+.1e}",
        f"{row[NEWEST]:.1e}",
        f"{row[LEFT]:.1e}",
        str(row["reason"]),
    )
