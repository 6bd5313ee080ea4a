"""Spans that a watch has something to say of, shaded behind a drawing over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from estimation.history_view import HistoryView
from estimation.status import Status
from estimation.watch.words import FLAGGED, shaded_spans

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS: Mapping[str, str] = {
    FLAGGED: "tab:orange",
    Status.LIVELIER.label: "tab:olive",
    Status.INCONSISTENT.label: "tab:purple",
    Status.LOST.label: "tab:red",
}
"""What is said → its colour; what stands last is drawn on top."""


def shade(axes: Axes, histories: Iterable[HistoryView]) -> None:
    """Shade the spans in which any of some histories was lost or flagged a sensor.

    However short a span is, its edge is seen.
    """
    found = [shaded_spans(history) for history in histories]
    for word, colour in COLOURS.items():
        of_all = [of_it[word] for of_it in found if word in of_it]
        if not of_all:
            continue
        starts, ends = np.concatenate(of_all).T
        axes.broken_barh(
            list(zip(starts, ends - starts, strict=True)),
            (0.0, 1.0),
            transform=axes.get_xaxis_transform(),
            facecolor=colour,
            edgecolor=colour,
            linewidth=0.4,
            alpha=0.25,
            zorder=0.5,
            label=word,
        )
