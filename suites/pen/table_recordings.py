"""The turntable's recordings, whoever is given which of their sensors."""

from __future__ import annotations

from functools import lru_cache

from estimation.recording import Recording
from models.table_motion import table_motions
from models.turntable import paper_turntable
from recordings.simulate_turntable import simulate_stroke, simulate_table
from suites.pen.turntable_starts import StartTrial


@lru_cache(maxsize=16)
def stroke_recording(stroke: str, seed: int) -> Recording:
    """Return a stroke as all sensors read it."""
    return simulate_stroke(paper_turntable(), table_motions()[stroke], seed)


@lru_cache(maxsize=16)
def start_recording(seed: int) -> Recording:
    """Return what every wrong start is told of: both axes run."""
    return simulate_table(paper_turntable(), StartTrial.duration_s, seed)
