"""What a window finds, as quantities; those that are 1 or 0 count windows."""

from __future__ import annotations

from benchmark.tasks.task import Outcome, Quantity
from estimation.status import Status
from suites.optimum.run import ABOVE, BELOW, IPOPT_FAILED, SAME, WindowRow

NEAR, APART, UNSAID = "same and near", "same, but apart", "above, unsaid"
"""In one minimum and near enough, or not; in a higher one without a word of it."""
COUNTED = (NEAR, APART, ABOVE, UNSAID, BELOW, IPOPT_FAILED)
NEWEST, COSTS, COST = "newest states apart", "costs apart, relative", "cost"
LEFT = "Newton step left"
RUNS = "runs of IPOPT"
NAN = float("nan")


def window_outcome(row: WindowRow, model: str) -> Outcome:
    """Return what became of a window. Nobody times it: others run beside it.

    Parameters
    ----------
    model : its name
    """
    counts = {
        NEAR: row.verdict == SAME and row.holds,
        APART: row.verdict == SAME and not row.holds,
        ABOVE: row.verdict == ABOVE,
        UNSAID: row.verdict == ABOVE and Status.IMPROBABLE not in row.status,
        BELOW: row.verdict == BELOW,
        IPOPT_FAILED: row.verdict == IPOPT_FAILED,
    }
    figures = {
        COSTS: row.relative,
        COST: row.cost,
        "cost of IPOPT": row.ipopt_cost,
        "iterations": row.iterations,
        "iterations of IPOPT": row.ipopt_iterations,
        RUNS: row.ipopt_runs,
        "states at bounds": row.at_bounds,
        "states at bounds of IPOPT": row.ipopt_at_bounds,
    }
    lengths = {
        NEWEST: row.newest_distance,
        LEFT: row.newton_length,
        f"{LEFT} of IPOPT": row.ipopt_newton_length,
    }
    found = [
        Quantity.single(name, unit, float(value))
        for unit, values in (("1", counts), ("1", figures), ("σ", lengths))
        for name, value in values.items()
    ]
    return Outcome(model, tuple(found), 1, float(row.status.is_solved), NAN, NAN, reason=_said(row))


def _said(row: WindowRow) -> str:
    """Return why a window does not hold, and what `mhe` says where it is not that all is well."""
    label = row.status.label
    said = f"mhe says {label}" if row.status and not row.reason.endswith(label) else ""
    return "; ".join(filter(None, (row.reason, said)))
