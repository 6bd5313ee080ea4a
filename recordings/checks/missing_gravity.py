"""Check: is gravity in the accelerometer?"""

from __future__ import annotations

from collections.abc import Iterator

from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.gravity_felt import felt_gravity


def check_missing_gravity(looked: Looked) -> Iterator[Finding]:
    """Find accelerometers without gravity: linear or user acceleration of a phone."""
    for name, (time_s, force) in looked.forces.items():
        felt = felt_gravity(time_s, force, looked.pen.gravity_m_s2)
        if not felt.is_there:
            yield Finding(
                f"there is no gravity in it: over a second its mean is {felt.mean_m_s2:.2g} m/s² "
                f"where {looked.pen.gravity_m_s2:.3g} is due (user or linear acceleration)",
                name,
                felt.sure,
                "record the accelerometer itself, with gravity; nothing brings it back",
                Severity.NOT_MEANT,
            )
