"""From the rows of a race to what the tasks found: one outcome a contender."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from benchmark.tasks.task import Outcome, Quantity
from suites.shared_core import judged
from suites.speed.clock import THREAD_CLOCK
from suites.speed.contender import Entry
from suites.speed.rows import Row

LEFT_OUT = "left out"
"""Status of a contender that is not there."""

LEAST_CPU, MEDIAN_CPU = "least CPU time", "median CPU time"
LEAST, MEDIAN, P99, LONGEST = "least time", "median time", "99 % time", "longest time"
COST, NEWEST, NEWEST_WORST = "cost", "newest state", "newest state at worst"
EXCESS, SOLVED, BUILD = "excess over bounds", "solved", "time to build"
CORES, ACTIVE = "cores", "active rows"

FIGURES: Sequence[tuple[str, str, Callable[[Row], float | None]]] = (
    (LEAST_CPU, "µs", lambda row: 1e6 * row.cpu_min_s),
    (MEDIAN_CPU, "µs", lambda row: 1e6 * row.cpu_median_s),
    (LEAST, "µs", lambda row: 1e6 * row.min_s),
    (MEDIAN, "µs", lambda row: 1e6 * row.median_s),
    (P99, "µs", lambda row: 1e6 * row.p99_s),
    (LONGEST, "µs", lambda row: 1e6 * row.max_s),
    (COST, "1", lambda row: row.cost),
    (NEWEST, "σ", lambda row: row.newest_error_std),
    (NEWEST_WORST, "σ", lambda row: row.newest_error_max_std),
    (EXCESS, "σ", lambda row: row.violation_std),
    (SOLVED, "1", lambda row: row.solved),
    (BUILD, "s", lambda row: row.build_s),
)
"""Name, unit and figure of what a row says of its mode."""


def named(mode: str, figure: str) -> str:
    """Return the name of the quantity that is a figure of a mode."""
    return f"{mode}: {figure}"


def outcomes(
    model: str, names: Sequence[str], rows: Sequence[Row], left_out: Mapping[Entry[Any], str]
) -> dict[str, Outcome]:
    """Return what each of the named contenders found.

    Parameters
    ----------
    model : name of the race's model
    rows : of the race; those of one contender stand in the order of its modes
    left_out : contender that could not be built → why
    """
    found = {}
    for name in names:
        missing = {entry: why for entry, why in left_out.items() if entry.name == name}
        of_it = [row for row in rows if row.contender == name]
        found[name] = _raced(model, of_it, missing) if of_it else _absent(missing)
    return found


def _absent(missing: Mapping[Entry[Any], str]) -> Outcome:
    nan, why = float("nan"), "; ".join(dict.fromkeys(missing.values()))
    return Outcome("", (), 0, 0.0, nan, nan, LEFT_OUT, why)


def _raced(model: str, rows: Sequence[Row], missing: Mapping[Entry[Any], str]) -> Outcome:
    first, share = rows[0], min(row.core_share for row in rows)
    status, why = judged(share)
    said = [
        *([why] if why else []),
        first.version,
        *(f"{row.mode}: CPU time by {row.clock}" for row in rows if row.clock != THREAD_CLOCK),
        *(f"{entry.mode}: {LEFT_OUT}, {why}" for entry, why in missing.items()),
    ]
    return Outcome(
        model,
        tuple(_quantities(rows, share)),
        first.windows,
        first.solved,
        first.median_s,
        first.p99_s,
        status,
        "; ".join(said),
    )


def _quantities(rows: Sequence[Row], share: float) -> Iterator[Quantity]:
    times = Counter(row.mode for row in rows)
    for row in rows:
        mode = row.mode if times[row.mode] == 1 else f"{row.mode}, N = {row.horizon}"
        for figure, unit, of in FIGURES:
            if (value := of(row)) is not None:
                yield Quantity.single(named(mode, figure), unit, value)
    if rows[0].active_rows is not None:
        yield Quantity.single(ACTIVE, "1", rows[0].active_rows)
    yield Quantity.single(CORES, "cores", share)
