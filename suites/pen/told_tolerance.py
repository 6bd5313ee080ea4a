"""How freely the rates of the turntable may change, as estimators are told: swept.

The tolerance of a rate is published; in what time the rate wanders by it
(`TurntableConfig.tolerance_reached_after_s`) is ours. The longer it is, the more constant a filter
takes the rates for, and the more of a changed reading at a corner it takes for a change of angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from models.turntable import TurntableConfig, paper_turntable

TOLD_TOLERANCE_S = (0.03, 0.1, 0.3, 3.0, 10.0)
"""Beside the turntable file's own."""

SWEEP_ESTIMATORS = ("ekf",)

SHOWN = ("compound: horizontal-turn-vertical", "compound: horizontal-turn-left-fall")
"""Strokes that figures show over time."""


@dataclass(frozen=True)
class ToldStroke:
    """A stroke, and the tolerance's time that estimators are told; None: the file's."""

    stroke: str
    reached_after_s: float | None = None


SWEEP: Mapping[str, ToldStroke] = MappingProxyType(
    {
        f"tolerance after {after_s:g} s, {stroke}": ToldStroke(stroke, after_s)
        for stroke in SHOWN
        for after_s in TOLD_TOLERANCE_S
    }
)
"""Case → stroke with another tolerance told; the table moves as its file says."""


def told_table(reached_after_s: float | None) -> TurntableConfig:
    """Return the turntable of [Pen] with the tolerance's time; None: the file's."""
    table = paper_turntable()
    if reached_after_s is None:
        return table
    return table.model_copy(update={"tolerance_reached_after_s": reached_after_s})
