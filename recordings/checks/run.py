"""All checks of the table, on one recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from estimation.recording import Recording
from models.pen_config import PenConfig
from recordings.checks.looked import Looked
from recordings.checks.sketch import Sketch
from recordings.checks.table import CHECKS
from recordings.finding import Finding, in_order, not_meant


def findings_of(
    recording: Recording,
    pen: PenConfig,
    *,
    columns: Mapping[str, tuple[str, ...]] | None = None,
    against_pen: bool = True,
) -> tuple[Finding, ...]:
    """Return what checks find in a recording, those first for which no answer can be meant.

    Parameters
    ----------
    pen : whose sensors it has
    columns : sensor → its columns in the file, where they have names of their own
    against_pen : whether mounting and noise of the pen are compared, too
    """
    sketch = Sketch()
    sketch.take(recording)
    return findings_of_sketch(sketch, pen, columns=columns, against_pen=against_pen)


@np.errstate(all="ignore")  # readings beyond any unit are found, not warned of
def findings_of_sketch(
    sketch: Sketch,
    pen: PenConfig,
    *,
    columns: Mapping[str, tuple[str, ...]] | None = None,
    against_pen: bool = True,
) -> tuple[Finding, ...]:
    """Return the same of a recording that was read in parts."""
    kept = sketch.end()
    if kept is None:
        return ()
    looked, found = Looked(kept[0], pen, kept[1], columns=columns), list[Finding]()
    spoiled: set[str] = set()
    for check in CHECKS:
        if spoiled & set(check.unless) or (check.of_pen and not against_pen):
            continue
        here = [replace(finding, check=check.name) for finding in check.find(looked)]
        if not_meant(here):
            spoiled.add(check.name)
        found += here
    return in_order(found)
