"""Names of the motions that a recording can be simulated along."""

from __future__ import annotations

from models.bundled import motion_rows

DRAWN = "model"
"""Name of the motion that is drawn from the pen's own prior and process noise."""


def motion_names() -> tuple[str, ...]:
    """Return the names that `recordings.simulate` knows: the table's motions, and `DRAWN`."""
    return (*motion_rows(), DRAWN)
