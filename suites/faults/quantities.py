"""What a run of the suite finds, as quantities; those that are 1 or 0 are 1 where it fails."""

from __future__ import annotations

import math

from benchmark.tasks.task import Quantity
from suites.faults.scoring import FaultScore
from suites.faults.table import Fault

WITHIN_S, LONG_WITHIN_S = 2.0, 3.0
"""How soon estimates should be right again; in the second after holes, and at 1 Hz."""
SILENT_WRONG, SILENT, WRONG = "silent wrong", "silent", "wrong"
RIGHT, ACCURATE = "right again", "accurate again"
PEAK, PEAK_TIP, PEAK_STDS = "peak error", "peak tip error", "peak error in deviations"
BROKE, FLAGS, LOST = "broke off or not finite", "flags", "lost"
REAL_FLAGS = "flags on a real recording"
STAYS = ", fault stays"


def not_within(what: str, within_s: float, fault: Fault | None = None) -> str:
    """Return e.g. ``not right within 2 s``, with a word behind it where a fault stays."""
    return f"not {what} within {within_s:g} s" + (STAYS if fault and fault.stays else "")


def fault_quantities(fault: Fault, score: FaultScore, sees_tip: bool) -> list[Quantity]:
    """Return what a run with a fault found.

    Parameters
    ----------
    sees_tip : whether its sensors show the tip
    """
    counted = {
        SILENT_WRONG: score.is_silent_wrong,
        not_within("right", WITHIN_S, fault): score.right_s > WITHIN_S,
        not_within("accurate", WITHIN_S, fault): score.accurate_s > WITHIN_S,
        not_within("right", LONG_WITHIN_S): score.right_s > LONG_WITHIN_S,
        BROKE: bool(score.broke) or not score.is_finite,
        "false flags": score.false_flags,
    }
    times = {
        SILENT: score.silent_s,
        WRONG: score.wrong_s,
        RIGHT: score.right_s,
        ACCURATE: score.accurate_s,
        "told": score.told_s,
        "flagged": score.flagged_s,
        "false flagged": score.false_flagged_s,
    }
    return [
        *(Quantity.single(name, "1", float(figure)) for name, figure in counted.items()),
        *(Quantity.single(name, "s", time) for name, time in times.items()),
        Quantity.single(PEAK, "deg", score.peak_deg),
        Quantity.single(PEAK_TIP, "mm", score.peak_mm if sees_tip else math.nan, sees_tip),
        Quantity.single(PEAK_STDS, "σ", score.peak_stds),
    ]
