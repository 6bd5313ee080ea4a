"""What ``run.json`` says, as lines of label and text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

LABELS: Mapping[str, str] = {
    "command": "Command",
    "suites": "Suites",
    "started": "Started",
    "seconds": "Duration, s",
    "sessions": "Sittings",
    "seeds": "Seeds",
    "jobs": "Jobs",
    "code": "Code",
    "versions": "Versions",
    "machine": "Machine",
    "git": "Git",
    "data": "Data",
}
"""Key of ``run.json`` → its label, in this order; others follow under their own name."""


def made_with(run: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return (label, text) for everything that a run says of itself; whatever is there."""
    keys = [key for key in LABELS if key in run] + [key for key in run if key not in LABELS]
    lines = [(LABELS.get(key, str(key)), _text(run[key])) for key in keys]
    return [(label, text) for label, text in lines if text]


def duration_s(run: Mapping[str, Any]) -> float | None:
    """Return the seconds that a run took, of all its sittings together; None if unknown."""
    sittings = run.get("sessions")
    parts = sittings if isinstance(sittings, list) and sittings else [run]
    found = [part.get("seconds") for part in parts if isinstance(part, Mapping)]
    known = [value for value in found if isinstance(value, int | float) and math.isfinite(value)]
    return sum(known) if known else None


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_text(entry)}" for key, entry in value.items())
    if isinstance(value, list | tuple):
        between = "; " if any(isinstance(entry, Mapping) for entry in value) else ", "
        return between.join(_text(entry) for entry in value)
    return str(value)
