"""Check: are stretches of readings missing?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity
from recordings.foreign.repairs import GAP_STEPS, LEAST_GAP_S

MOST = 0.5
"""Part of the time without readings from which on an estimate is mostly invented."""


def check_gaps(looked: Looked) -> Iterator[Finding]:
    """Find gaps between readings of inertial sensors."""
    for name in looked.inertial:
        starts, steps = looked.steps_of(name)
        if not len(steps):
            continue
        gaps = np.flatnonzero(steps > max(GAP_STEPS * float(np.median(steps)), LEAST_GAP_S))
        if not len(gaps):
            continue
        worst = gaps[np.argmax(steps[gaps])]
        part = float(steps[gaps].sum() / steps.sum())
        many = "one gap" if len(gaps) == 1 else f"{len(gaps)} gaps, {part:.2g} of the time"
        yield Finding(
            f"{many}, the longest of {steps[worst]:.3g} s from {starts[worst]:.5g} s on",
            name,
            1.0,
            "there an estimate only goes on by its model; look for what the logger dropped",
            Severity.NOT_MEANT if part > MOST else Severity.REMARK,
        )
