"""Check: do readings make sense in their units?"""

from __future__ import annotations

from collections.abc import Iterator

from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.plausible_units import unit_verdicts


def check_unit_of_readings(looked: Looked) -> Iterator[Finding]:
    """Find sensors whose readings only make sense in another unit."""
    for name, refusal in unit_verdicts(looked.recording, looked.pen).items():
        if refusal is not None:
            what, _, remedy = str(refusal).partition(", expected ")
            _, _, what = what.partition(f": {name} ")
            yield Finding(f"it {what}", name, 0.95, f"expected SI, or {remedy}", Severity.NOT_MEANT)
