"""Check: are times seconds?"""

from __future__ import annotations

from collections.abc import Iterator

from models.errors import InputError
from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.foreign.header_units import KNOWN_UNITS
from recordings.foreign.time_units import check_time_unit


def check_unit_of_times(looked: Looked) -> Iterator[Finding]:
    """Find times in which no inertial sensor has such a rate, and in another unit it would."""
    for name in looked.inertial:
        try:
            check_time_unit("time_s", KNOWN_UNITS["s"], looked.raw[name][0], "")
        except InputError as refusal:
            what, _, remedy = str(refusal).partition(", expected ")
            yield Finding(
                what.removeprefix(": column time_s ").replace("was read", "they were read"),
                f"times of {name}",
                0.99,
                f"expected seconds, or {remedy}",
                Severity.NOT_MEANT,
            )
            return
