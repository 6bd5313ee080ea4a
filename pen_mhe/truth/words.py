"""What is said of a truth that was laid on an estimate, in one line."""

from __future__ import annotations

import numpy as np

from models.arrays import Array
from pen_mhe.truth.align import Alignment
from pen_mhe.truth.frame import UPS

_UP_WORDS = ("z", "-z", "y", "-y", "x", "-x")
NEAR = 1e-6
FINEST, FINEST_DIGITS = 1e-6, 6
"""No offset, s, or turn, °, is told more finely."""


def alignment_sentence(alignment: Alignment) -> str:
    """Return what was found, by which method, and how many numbers were fitted."""
    count = alignment.fitted.unknowns.count
    numbers = (
        "nothing is fitted"
        if not count
        else f"{count} number{'s' if count > 1 else ''} fitted to the estimate, so errors are "
        "smaller by what they explain"
    )
    return "; ".join([_clock_words(alignment), *_frame_words(alignment), numbers])


def _clock_words(alignment: Alignment) -> str:
    best, found = alignment.fitted, alignment.found
    offset = best.clocks.offset_s
    if found is None:
        return f"its clock {_signed(offset, 6)} s, as said"
    digits, std = _with_digits(best.offset_std_s)
    said = (
        f"its clock {_signed(offset, digits)} ± {std} s (correlation of "
        f"{found.name} {found.correlation:.2f}, then least squares)"
    )
    if np.isnan(alignment.drift):
        return said
    ends_s = abs(alignment.drift) * alignment.span_s / 2
    drift = (
        f"a drift of {1e6 * alignment.drift:.0f} ± {1e6 * alignment.drift_std:.0f} ppm "
        f"({1e3 * ends_s:.2g} ms at the ends)"
    )
    return f"{said}, {drift} {'is taken off' if alignment.drift_matters else 'does not matter'}"


def _frame_words(alignment: Alignment) -> list[str]:
    best, unknowns = alignment.fitted, alignment.fitted.unknowns
    frame = best.frame
    if not (unknowns.turns or unknowns.shifts or unknowns.mount):
        return []
    said = []
    digits, std = _with_digits(np.degrees(best.heading_std_rad))
    heading = f"{np.degrees(frame.heading_rad):.{digits}f} ± {std}°"
    if unknowns.turns == 3:
        tilt = np.degrees(np.arccos(np.clip(frame.up[2], -1, 1)))
        said.append(f"turned by {heading} about the vertical, which leans by {tilt:.1f}° in it")
    elif unknowns.turns == 1:
        up = next(w for w, up in zip(_UP_WORDS, UPS, strict=True) if up @ frame.up > 1 - NEAR)
        upward = "" if up == "z" else f"with its {up} upward "
        said.append(f"{upward}turned by {heading} about the vertical")
    if unknowns.shifts:
        said.append(f"shifted by {_mm(frame.shift[: unknowns.shifts])}")
    if unknowns.mount:
        angle = np.degrees(np.arccos(np.clip((np.trace(frame.mount) - 1) / 2, -1, 1)))
        said.append(f"the marker turned by {angle:.1f}° on the pen")
    if unknowns.lever:
        said.append(f"the tip at {_mm(frame.lever)} of it")
    return [f"its frame {said[0]}", *said[1:]] if unknowns.turns or unknowns.shifts else said


def _signed(value: float, digits: int) -> str:
    return f"{'+' if value >= 0 else '-'} {abs(value):.{digits}f}"


def _mm(vector: Array) -> str:
    return f"({', '.join(f'{1e3 * value:.1f}' for value in vector)}) mm"


def _with_digits(std: float) -> tuple[int, str]:
    """Return the digits that a number has, and its deviation with one or two of its own."""
    if not FINEST < std < np.inf:
        return FINEST_DIGITS, f"{FINEST:.{FINEST_DIGITS}f}"
    more = 1 if f"{std:.0e}"[0] == "1" else 0
    digits = min(max(more - int(np.floor(np.log10(std))), 0), FINEST_DIGITS)
    return digits, f"{std:.{digits}f}"
