"""Several histories side by side: a table of errors beside what is claimed, and a drawing."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from estimation.history import EstimateHistory
from estimation.history_plot import drawn_states, known_units, plot_histories
from estimation.reading_columns import check_mapping
from estimation.recording import Truth
from models.errors import InputError
from models.names import unknown
from models.units import readable_unit, shown, split_unit
from pen_mhe.errors import ERROR_COLUMNS, root_mean_square

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Columns = Mapping[str, tuple[tuple[str, ...], float]]


@dataclass(frozen=True, eq=False, repr=False)
class HistoryComparison:
    """What `compare` returns; see there."""

    histories: Mapping[str, EstimateHistory]
    truth: Truth | None
    states: tuple[str, ...]

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row per history.

        Columns: RMS error (``…_rms``, where there is truth) beside the root mean square of what
        the estimator claims (``…_std``), which is as large if it is right; ``nis_per_row``, near
        1 if innovations are as large as they are claimed to be; ``solved``, a fraction; steps and
        their median time.
        """
        import pandas as pd

        known = known_units(self.histories.values())
        columns = error_columns(self.states, known)
        rows = [self._row(history, columns) for history in self.histories.values()]
        return pd.DataFrame(rows, index=pd.Index(list(self.histories), name="history"))

    @cached_property
    def figure(self) -> Figure:
        """The states over time with their ± 2 σ, a colour per history."""
        units = known_units(self.histories.values())
        drawn = drawn_states({name: units[name] for name in self.states})
        return plot_histories(self.histories, drawn, truth=self.truth)

    def _row(self, history: EstimateHistory, columns: Columns) -> dict[str, Any]:
        told = history.first_told()  # an instant that is told again counts once
        rms = (
            {}
            if self.truth is None
            else root_mean_square(told.names, told.errors(self.truth), columns)
        )
        claimed = root_mean_square(told.names, told.values_std, columns)
        row: dict[str, Any] = {}
        for column in columns:
            if self.truth is not None and set(columns[column][0]) & set(self.truth.names):
                row[f"{column}_rms"] = rms.get(column, np.nan)
            row[f"{column}_std"] = claimed.get(column, np.nan)
        row["nis_per_row"] = nis_per_row(history)
        row["solved"] = history.solved_fraction
        row["steps"] = len(history)
        row["median_step_ms"] = 1e3 * float(np.median(history.step_time_s))
        return row

    def __repr__(self) -> str:
        return self.table.T.to_string(float_format="{:.4g}".format)

    def _repr_html_(self) -> str:
        image = io.BytesIO()
        self.figure.savefig(image, format="png", dpi=100)
        data = base64.b64encode(image.getvalue()).decode()
        table = self.table.T.to_html(float_format="{:.4g}".format)
        names = escape(", ".join(self.histories))
        return f"{table}<img alt='states over time: {names}' src='data:image/png;base64,{data}'>"


def compare(
    histories: Mapping[str, EstimateHistory],
    truth: Truth | None = None,
    *,
    states: Sequence[str] | None = None,
) -> HistoryComparison:
    """Compare runs of one or several estimators, of one or several sensor sets.

    Parameters
    ----------
    histories : by the name that table and drawing show
    truth : true states, where they are known
    states : names to compare and to draw; None compares tip, angles and rates of a pen, all but
        biases of any other model, and draws positions and angles

    Returns
    -------
    A comparison with ``table`` and ``figure``, which a notebook shows by itself.

    Raises
    ------
    InputError
        If there is no history by name, one has no step, or no history has one of the states. The
        table and the figure do so where a history has an instant without truth.
    """
    check_mapping(histories, "histories to compare", "name → history")
    if not histories:
        raise InputError("no history to compare, expected at least one by name")
    for label, history in histories.items():
        if len(history) == 0:
            raise InputError(f"the history {label} has no steps, expected at least one")
    known = list(dict.fromkeys(name for h in histories.values() for name in h.names))
    for name in states or ():
        if name not in known:
            raise unknown("state", name, known)
    chosen = _usual_states(known) if states is None else states
    return HistoryComparison(dict(histories), truth, tuple(chosen))


def _usual_states(known: Sequence[str]) -> list[str]:
    of_pens = {name for group, _ in ERROR_COLUMNS.values() for name in group}
    found = [name for name in known if name in of_pens]
    return found or [name for name in known if "bias" not in name] or list(known)


def error_columns(
    states: Sequence[str], known: Mapping[str, str]
) -> dict[str, tuple[tuple[str, ...], float]]:
    """Return the columns of an error table for some states, as of `pen_mhe.errors.ERROR_COLUMNS`.

    A pen's groups, where all of their states that are known at all are among them, and each
    other state by itself: angles in degrees, in a column that says so.

    Parameters
    ----------
    known : name → unit of all states that there are
    """
    columns: dict[str, tuple[tuple[str, ...], float]] = {}
    taken: set[str] = set()
    for column, (group, factor) in ERROR_COLUMNS.items():
        here = tuple(name for name in group if name in known)
        if here and set(here) <= set(states):
            columns[column] = (here, factor)
            taken |= set(here)
    for name in states:
        if name not in taken:
            factor = shown(name, known[name])[2]
            columns[_column(name, known[name]) if factor != 1 else name] = ((name,), factor)
    return columns


def _column(angle: str, unit: str) -> str:
    """Return the name of an angle's column in degrees."""
    stem, suffix = split_unit(angle)
    if unit != readable_unit(suffix):
        stem, suffix = angle, unit.replace("/", "_").replace("²", "2")
    return f"{stem}_{suffix.replace('rad', 'deg', 1)}"


def nis_per_row(history: EstimateHistory) -> float:
    """Return the mean normalised innovation squared per row that measured; NaN without any."""
    names = list(history.row_sets)
    if "measured" not in names:
        return float("nan")
    squared = history.squared_innovations[:, names.index("measured")]
    rows = (~np.isnan(history.innovation[:, history.row_sets["measured"]])).sum()
    return float(np.nansum(squared) / rows) if rows else float("nan")
