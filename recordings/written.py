"""A recording with the ink that it left on paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from estimation.recording import Recording
from models.pen_config import PenConfig
from recordings.checks.run import findings_of
from recordings.finding import Finding, in_order
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

    def checked(
        self, used: Recording, pen: PenConfig, *, against_pen: bool = True
    ) -> WrittenRecording:
        """Return it with what checks find, those first for which no estimate can be meant.

        Parameters
        ----------
        used : what is used of it
        pen, against_pen : see `recordings.checks.run.findings_of`
        """
        known = {finding.check for finding in self.findings}
        found = findings_of(used, pen, columns=self.columns, against_pen=against_pen)
        more = [finding for finding in found if finding.check not in known]
        return replace(self, findings=in_order([*self.findings, *more]))

    def sentences(self) -> list[str]:
        """Return what the reader says of the file."""
        return [*self.notes, *(finding.sentence() for finding in self.findings)]
