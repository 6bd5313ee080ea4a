"""Figures as text."""

from __future__ import annotations

import math

NONE, NEVER = "–", "∞"
DIGITS = 3
"""Significant digits."""

TIME_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


def number(value: float) -> str:
    """Return a figure with three significant digits; ``–`` for NaN, ``∞`` for infinity."""
    if math.isnan(value):
        return NONE
    sign = "−" if value < 0 else ""
    size = abs(float(value))
    if math.isinf(size):
        return sign + NEVER
    if size == 0:
        return "0"
    if not 1e-4 <= size < 1e6:
        return sign + f"{size:.{DIGITS - 1}e}"
    # After rounding: 0.9999 has as many decimals as 1.00.
    rounded = float(f"{size:.{DIGITS - 1}e}")
    decimals = max(DIGITS - 1 - math.floor(math.log10(rounded)), 0)
    return sign + f"{size:.{decimals}f}"


def interval(low: float, high: float) -> str:
    """Return ``0.1 to 0.3``; empty where there is none or its ends are the same."""
    if math.isnan(low) or math.isnan(high) or low == high:
        return ""
    return f"{number(low)} to {number(high)}"


def seconds(value: float) -> str:
    """Return a short time with its unit: ``85.0 µs``."""
    for scale, unit in ((1e-6, "µs"), (1e-3, "ms")):
        if abs(value) < 1000 * scale:
            return f"{number(value / scale)} {unit}"
    return f"{number(value)} s"


def in_unit(time_s: float) -> str:
    """Return a time with a unit that leaves 1 to 3 digits in front: ``46 µs``."""
    for scale, unit in TIME_UNITS:
        if time_s >= scale * (1 - 1e-9):
            return f"{time_s / scale:.3g} {unit}"
    return f"{time_s / TIME_UNITS[-1][0]:.3g} {TIME_UNITS[-1][1]}"


def count(n: int, of: str) -> str:
    """Return ``1 seed``, ``2 seeds``."""
    return f"{n} {of}" if n == 1 else f"{n} {of}s"
