"""Check: is gravity as long as it is, and do rates turn it as fast?

A range that is set otherwise in the sensor than in the logger doubles or halves readings: too
little for a unit, and wrong all the same.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from recordings.checks.handedness import LEAST_CORRELATION, wrong_axes
from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.gravity_felt import felt_gravity

OFF, FAR_OFF = 1.12, 1.4
"""Times by which gravity differs from what is due: to remark, and to be no answer."""
RATE_OFF = 1.6
"""The same of a gyroscope, from turning, to which a hand's acceleration adds."""


def check_scale(looked: Looked) -> Iterator[Finding]:
    """Find accelerometers and gyroscopes with a factor of their own."""
    gravity = looked.pen.gravity_m_s2
    for name, (time_s, force) in looked.forces.items():
        # A hand's acceleration makes |f| longer, turning makes its mean shorter.
        longest = float(np.median(np.linalg.norm(force, axis=1)))
        shortest = felt_gravity(time_s, force, gravity).mean_m_s2
        length = shortest if shortest > gravity else min(longest, gravity)
        factor = length / gravity
        if not 1 / OFF < factor < OFF and longest > 0:
            yield Finding(
                f"gravity in it is {length:.3g} m/s², {factor:.2g} times what is due",
                name,
                0.9,
                "look at the range that is set in it and that its counts are scaled by, or give "
                "its bias and sensitivity in the pen file (pen-mhe calibrate still)",
                Severity.REMARK if 1 / FAR_OFF < factor < FAR_OFF else Severity.NOT_MEANT,
            )
    for pair in looked.pairs:
        if pair.fit is None:
            continue
        way = wrong_axes(pair.fit) or 0
        k = float(pair.fit.factor[way])
        if pair.fit.correlation[way] > LEAST_CORRELATION and not 1 / RATE_OFF < k < RATE_OFF:
            yield Finding(
                f"its rates are {1 / k:.2g} times as fast as gravity turns in {pair.force}",
                pair.rate,
                0.9,
                "look at the range that is set in it and that its counts are scaled by, and at "
                "the unit of its columns",
                Severity.NOT_MEANT,
            )
