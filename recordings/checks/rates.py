"""Check: do inertial sensors read as often as a hand moves?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from recordings.checks.looked import Looked
from recordings.finding import Finding

SLOW_HZ = 15.0
"""Below, much of what a writing hand does lies between two readings."""


def check_rates(looked: Looked) -> Iterator[Finding]:
    """Find sensors that are too slow for a hand."""
    for name in looked.inertial:
        _, steps = looked.steps_of(name)
        rate_hz = 1 / float(np.median(steps)) if len(steps) else np.inf
        if rate_hz < SLOW_HZ:
            yield Finding(
                f"{rate_hz:.3g} readings a second, too few to follow a hand",
                name,
                1.0,
                "record at 50 Hz or more",
            )
