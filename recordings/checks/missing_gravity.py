"""Check: is gravity in the accelerometer?"""

from __future__ import annotations

from collections.abc import Iterator

from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.gravity_felt import NOTHING, felt_gravity
from recordings.plausible_units import unit_verdicts


def check_missing_gravity(looked: Looked) -> Iterator[Finding]:
    """Find accelerometers without gravity: linear or user acceleration of a phone."""
    gravity = looked.pen.gravity_m_s2
    for name, (time_s, force) in looked.forces.items():
        felt = felt_gravity(time_s, force, gravity)
        if felt.mean_m_s2 == 0:
            continue
        is_there = felt.is_there
        if felt.mean_m_s2 < NOTHING * gravity:
            # So little is gravity in another unit, or none.
            is_there &= unit_verdicts(looked.recording, looked.pen).get(name) is not None
        if not is_there:
            yield Finding(
                f"there is no gravity in it: over a second its mean is {felt.mean_m_s2:.2g} m/s² "
                f"where {gravity:.3g} is due (user or linear acceleration)",
                name,
                0.98,
                "record the accelerometer itself, with gravity; nothing brings it back",
                Severity.NOT_MEANT,
            )
