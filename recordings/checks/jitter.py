"""Check: are stamps those of sampling?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from recordings.checks.looked import Looked
from recordings.finding import Finding
from recordings.foreign.repairs import GAP_STEPS

MOST = 0.4
"""Deviation of the steps between stamps, in median steps; gaps do not count."""
FEWEST = 50


def check_jitter(looked: Looked) -> Iterator[Finding]:
    """Find stamps that are those of arrival, or too coarse."""
    for name in looked.inertial:
        _, steps = looked.steps_of(name)
        if len(steps) < FEWEST:
            continue
        median = float(np.median(steps))
        std = float(np.std(steps[steps < GAP_STEPS * median]))
        if std > MOST * median:
            yield Finding(
                f"steps between stamps vary by {1e3 * std:.3g} ms about {1e3 * median:.3g} ms, "
                "as stamps of arrival do, or coarse ones",
                name,
                0.95,
                "stamp readings where they are sampled, or by their number and rate",
            )
