"""States over time, with what their estimators claim: a panel each, several histories in one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from estimation.history_rows import first_rows
from estimation.history_view import HistoryView
from estimation.recording import Truth
from estimation.watch.shades import shade
from models.arrays import Array
from models.errors import InputError
from models.names import several, unknown
from models.units import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HistoryT = TypeVar("HistoryT", bound=HistoryView)

Curve = tuple[Array, Array, Array]
"""Times, values and standard deviations, (n,) each."""

TURN = 2 * np.pi

SHOWN_UNITS = ("m", "rad")
"""States in these units are drawn where none are named: positions and angles."""

MOST_PANELS = 8

MOST_POINTS = 10_000
"""Of a curve; a longer one is drawn by the lowest and the highest estimate of each of its parts."""

SMALL_M = 1.0
"""Lengths that stay below are shown in mm."""

SETTLED_BELOW = 5.0
"""Median deviations of a run within which an estimate decides what an axis shows: the first
instants are as wide as the prior and would hide the rest."""

TRUTH_STYLE: Mapping[str, Any] = {"color": "black", "linewidth": 1.0, "zorder": 3}


def labelled(
    first: HistoryT, others: Iterable[HistoryT] | Mapping[str, HistoryT]
) -> dict[str, HistoryT]:
    """Return histories by label: given ones, or estimators' names, numbered where they repeat."""
    if isinstance(others, Mapping):
        pairs = [(first.estimator, first), *others.items()]
    else:
        pairs = [(history.estimator, history) for history in (first, *others)]
    repeated, found = Counter(label for label, _ in pairs), dict[str, HistoryT]()
    for label, history in pairs:
        number = sum(name.startswith(f"{label} ") or name == label for name in found) + 1
        found[f"{label} {number}" if repeated[label] > 1 else label] = history
    return found


def plot_histories(
    histories: Mapping[str, HistoryView],
    states: Sequence[str] | None = None,
    *,
    truth: Truth | None = None,
) -> Figure:
    """Draw states of one or several histories with their ± 2 σ; returns the figure.

    Where one of them was watched, spans in which it was lost or flagged a sensor are shaded.

    Parameters
    ----------
    histories : by label, at least one
    states : names; a history without one of them is left out of its panel. None draws
        positions and angles, or else the first states, at most `MOST_PANELS`
    truth : drawn where it names the state

    Raises
    ------
    InputError
        If there is no history, or a state is in none of them.
    """
    if not histories:
        raise InputError("no history to draw, expected at least one")
    known = known_units(histories.values())
    chosen = drawn_states(known) if states is None else list(several(states))
    for state in chosen:
        if state not in known:
            raise unknown("state", state, known)
    columns = 1 if len(chosen) < 4 else 2
    rows = -(-len(chosen) // columns)
    figure = new_figure(5.5 * columns + 1.0, 1.2 + 1.7 * rows)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    panels = list(grid.T.ravel())  # down the first column, then down the second
    for panel, state in zip(panels, chosen, strict=False):
        _draw(panel, histories, state, known[state], truth)
    for panel in panels[len(chosen) :]:
        panel.set_visible(False)
    for column in range(columns):
        bottom = panels[min((column + 1) * rows, len(chosen)) - 1]
        bottom.set_xlabel("time (s)")
        bottom.tick_params(labelbottom=True)
    _legend(figure, panels[: len(chosen)])
    figure.align_ylabels()
    return figure


def known_units(histories: Iterable[HistoryView]) -> dict[str, str]:
    """Return name → unit of all that some histories say."""
    return {name: history.unit_of(name) for history in histories for name in history.names}


def drawn_states(known: Mapping[str, str]) -> list[str]:
    """Return which of some states, with their units, are drawn where none are named."""
    found = [name for name, unit in known.items() if unit in SHOWN_UNITS]
    found = [name for name in found if "bias" not in name] or found
    return (found or list(known))[:MOST_PANELS]


def _legend(figure: Figure, panels: Iterable[Axes]) -> None:
    from matplotlib.patches import Patch

    handles: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    handles["± 2 σ"] = Patch(color="0.5", alpha=0.3, linewidth=0)
    columns = min(len(handles), 6)
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=columns)


def _draw(
    panel: Axes,
    histories: Mapping[str, HistoryView],
    state: str,
    unit: str,
    truth: Truth | None,
) -> None:
    words, unit, factor = shown(state, unit)
    curves = {
        label: _curve(h, state)
        for label, h in histories.items()
        if state in h.names and len(h.time_s)
    }
    true = None
    if truth is not None and state in truth.names:
        true = truth.values[:, truth.names.index(state)]
    if any(h.is_circular(state) for h in histories.values() if state in h.names):
        curves, true = _unwound(curves, truth, true)
    low, high = _settled(curves.values())
    if unit == "m" and max(-low, high) < SMALL_M:
        unit, factor = "mm", 1e3
    for label, (time_s, value, std) in curves.items():
        colour = f"C{list(histories).index(label) % 10}"
        time_s, value, std = _thinned(time_s, value, std)
        band = factor * (value - 2 * std), factor * (value + 2 * std)
        panel.fill_between(time_s, *band, alpha=0.2, color=colour, linewidth=0)
        panel.plot(time_s, factor * value, color=colour, linewidth=1.0, label=_plain(label))
    if truth is not None and true is not None:
        panel.plot(truth.time_s, factor * true, label="truth", **TRUTH_STYLE)
    panel.set_ylabel(_plain(f"{words} ({unit})" if unit else words))
    shade(panel, histories.values())
    panel.margins(x=0)
    panel.grid(alpha=0.3)
    margin = 0.05 * (high - low)
    if np.isfinite(margin) and margin > 0:
        panel.set_ylim(factor * (low - margin), factor * (high + margin))


def _plain(text: str) -> str:
    """Return a text that matplotlib shows as it is, instead of taking parts of it for formulas."""
    return text.replace("$", r"\$")


def _curve(history: HistoryView, state: str) -> Curve:
    """Return a state over time, each instant as it was told first."""
    rows = first_rows(history.time_s)
    return history.time_s[rows], history.column(state)[rows], history.std_of(state)[rows]


def _settled(curves: Iterable[Curve]) -> tuple[float, float]:
    """Return from where to where curves lie, with 2 σ, once their estimators have settled."""
    lows, highs = [], []
    for _, value, std in curves:
        known = np.isfinite(value) & np.isfinite(std)
        if known.any():
            kept = known & (std <= SETTLED_BELOW * np.median(std[known]))
            lows.append(float((value - 2 * std)[kept].min()))
            highs.append(float((value + 2 * std)[kept].max()))
    return min(lows, default=np.nan), max(highs, default=np.nan)


def _thinned(time_s: Array, value: Array, std: Array) -> Curve:
    """Return a curve of at most `MOST_POINTS` that still has every peak."""
    n_parts = MOST_POINTS // 2
    if len(value) <= MOST_POINTS:
        return time_s, value, std
    length = -(-len(value) // n_parts)
    starts = np.arange(0, len(value), length)
    parts = np.resize(np.nan_to_num(value), (len(starts), length))
    parts.ravel()[len(value) :] = parts.ravel()[len(value) - 1]
    ends = np.sort([parts.argmin(axis=1), parts.argmax(axis=1)], axis=0)
    rows = np.minimum((starts + ends).T.ravel(), len(value) - 1)
    return time_s[rows], value[rows], std[rows]


def _unwound(
    curves: Mapping[str, Curve], truth: Truth | None, true: Array | None
) -> tuple[dict[str, Curve], Array | None]:
    """Return curves of an angle without jumps, all within half a turn of the first one."""
    if truth is not None and true is not None:
        true = _without_jumps(true)
        reference = (truth.time_s, true)
    elif curves:
        time_s, value, _ = next(iter(curves.values()))
        reference = (time_s, _without_jumps(value))
    else:
        return dict(curves), true
    found = {}
    for label, (time_s, value, std) in curves.items():
        near = np.interp(time_s, *reference)
        found[label] = (time_s, value + TURN * np.round((near - value) / TURN), std)
    return found, true


def _without_jumps(angle: Array) -> Array:
    known = ~np.isnan(angle)
    result = angle.copy()
    result[known] = np.unwrap(angle[known])
    return result


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, which a notebook shows once."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt  # 0.5 s to import, which a live estimator has no use for

    figure = plt.figure(figsize=(width, height), layout="constrained")
    if "inline" in mpl.get_backend().lower():
        plt.close(figure)  # a cell shows the figure that it returns; an open one a second time
    return figure
