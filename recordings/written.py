"""A recording with the ink that it left on paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from estimation.recording import Recording
from recordings.finding import Finding
from recordings.ink import Ink


@dataclass(frozen=True, eq=False)
class WrittenRecording:
    """A recording with the ink it left, where there is a scan.

    Parameters
    ----------
    notes : sentences on what was recognised, ignored and repaired in a file of somebody else's
    findings : what an estimate may suffer from
    columns : sensor → its columns in a file of somebody else's, axis by axis
    """

    recording: Recording
    ink: Ink | None = None
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def sentences(self) -> list[str]:
        """Return what the reader says of the file."""
        return [*self.notes, *(finding.sentence() for finding in self.findings)]
