"""A history in words: a line for a prompt, a table for a notebook."""

from __future__ import annotations

from collections import Counter
from html import escape

import numpy as np

from estimation.history_view import HistoryView
from estimation.status import solved_fraction
from models.units import shown


def summary(history: HistoryView) -> str:
    """Return one line: whose, how many steps, from when to when, how they ended."""
    n, n_x = history.mean.shape
    if n == 0:
        return f"of {history.estimator}: no steps, {n_x} states"
    return (
        f"of {history.estimator}: {n} steps, {history.time_s[0]:g} s to {history.time_s[-1]:g} s, "
        f"{n_x} states, {solved_fraction(history.status):.2%} solved, "
        f"median step {1e3 * np.median(history.step_time_s):.3g} ms"
    )


def html(history: HistoryView) -> str:
    """Return a table of the states: the last estimate ± its deviation, and the range of the run."""
    head = f"<b>EstimateHistory</b> {escape(summary(history))}"
    remarks = Counter(history.status).most_common()
    told = ", ".join(f"{status.label} {count}" for status, count in remarks)
    if len(history.time_s) == 0:
        return head
    rows = []
    for name in history.names:
        quantity, unit, factor = shown(name, history.unit_of(name))
        mean, std = factor * history.column(name), factor * history.std_of(name)
        cells = (
            f"{mean[-1]:.4g} ± {std[-1]:.2g}",
            f"{np.median(std):.2g}",
            f"{mean.min():.4g} … {mean.max():.4g}",
        )
        numbers = "".join(f"<td style='text-align:right'>{cell}</td>" for cell in cells)
        words = f"<td style='text-align:left'>{escape(quantity)}</td><td>{escape(unit)}</td>"
        rows.append(f"<tr>{words}{numbers}</tr>")
    titles = ("state", "unit", "last ± σ", "median σ", "range")
    header = "".join(f"<th>{title}</th>" for title in titles)
    return f"{head}<br>status: {escape(told)}<table><tr>{header}</tr>{''.join(rows)}</table>"
