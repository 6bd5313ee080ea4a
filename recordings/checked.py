"""A recording checked before anybody estimates it: what it is, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from estimation.recording import Recording
from models.errors import InputError
from models.pen_file import AnyPen, as_pen
from models.shown_text import one_line
from recordings.asked import ColumnsAsked
from recordings.finding import Finding, finding_lines, not_meant, span_words
from recordings.read import RecordingPath, read_written
from recordings.written import WrittenRecording

SENSORS_OF = "reference"
"""The pen whose sensors' names and kinds are taken where no pen is given."""
NOTHING = "nothing is wrong that shows: checks see what contradicts itself, the table, or the pen"


@dataclass(frozen=True, eq=False, repr=False)
class CheckedRecording:
    """What checks found in a recording; prints itself.

    Parameters
    ----------
    name : of the recording
    sensors : a row per sensor: its readings, from when to when, their rate
    findings : those first for which no estimate can be meant
    notes : what was recognised, ignored and repaired in the file
    """

    name: str
    sensors: pd.DataFrame
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()

    @property
    def is_meant(self) -> bool:
        """Whether an estimate of this recording can be meant."""
        return not not_meant(self.findings)

    @property
    def table(self) -> pd.DataFrame:
        """A row per finding: check, severity, where, from when to when, how sure, what, remedy."""
        columns = ["check", "severity", "where", "start_s", "end_s", "sure", "what", "remedy"]
        rows = [
            [
                *(found.check, found.severity.value, found.where),
                *(found.span_s or (np.nan, np.nan)),
                *(found.sure, found.what, found.remedy),
            ]
            for found in self.findings
        ]
        return pd.DataFrame(rows, columns=columns)

    @property
    def text(self) -> str:
        """All of it in words."""
        lines = [one_line(self.name)]
        for row in self.sensors.to_dict("records"):
            span = span_words(row["start_s"], row["end_s"])
            told = f"{row['sensor']}: {row['readings']} readings, {span}, {row['rate_hz']:.4g} Hz"
            lines.append(f"  {told}")
        lines += [f"  {note}" for note in self.notes]
        for found in self.findings:
            lines += ["", *finding_lines(found)]
        return "\n".join([*lines, "", self.verdict])

    @property
    def verdict(self) -> str:
        """What it comes to, in one line."""
        wrong = not_meant(self.findings)
        if wrong:
            checks = ", ".join(dict.fromkeys(finding.check for finding in wrong))
            return f"an estimate of this recording cannot be meant: {checks}"
        if self.findings:
            return "an estimate can be meant, with the remarks above"
        return NOTHING

    def __repr__(self) -> str:
        return self.text


def check(
    recording: Recording | WrittenRecording | RecordingPath,
    pen: AnyPen | None = None,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
) -> CheckedRecording:
    """Check a recording: rates, gaps, clipping, units, gravity, signs, axes, mounting, noise, lag.

    Parameters
    ----------
    recording : a recording, with the ink it left or without, or the path of one
    pen : a pen, the name of a bundled one, or the path of a pen file. None takes the names
        of the reference pen's sensors, and compares neither mounting nor noise
    units, columns, strict : of a file, see `recordings.read.read_written`

    Raises
    ------
    InputError
        If it cannot be read: the message says why, also where its units cannot be.
    """
    config = as_pen(SENSORS_OF if pen is None else pen)
    if isinstance(recording, Recording):
        recording = WrittenRecording(recording)
    if not isinstance(recording, WrittenRecording):
        recording = read_written(recording, config, units=units, columns=columns, strict=strict)
    elif units or columns:
        what = "units" if units else "columns"
        raise InputError(f"{what} are given for a recording, expected none: its are SI")
    checked = recording.checked(recording.recording, config, against_pen=pen is not None)
    return CheckedRecording(
        recording.recording.name,
        _sensors(recording.recording),
        checked.findings,
        recording.notes,
    )


def _sensors(recording: Recording) -> pd.DataFrame:
    rows = []
    for name in recording.readings:
        times, _ = recording.sensor(name)
        rate_hz = 1 / float(np.median(np.diff(times))) if len(times) > 1 else np.nan
        ends = (float(times[0]), float(times[-1])) if len(times) else (np.nan, np.nan)
        rows.append([name, len(times), *ends, rate_hz])
    return pd.DataFrame(rows, columns=["sensor", "readings", "start_s", "end_s", "rate_hz"])
