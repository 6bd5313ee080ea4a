"""A recording with the ink that it left on paper."""

from __future__ import annotations

from dataclasses import dataclass

from estimation.recording import Recording
from recordings.ink import Ink


@dataclass(frozen=True, eq=False)
class WrittenRecording:
    """A recording with the ink it left, where there is a scan."""

    recording: Recording
    ink: Ink | None = None
