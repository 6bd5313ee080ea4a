"""What is wrong with a recording, or may be: an entry of a list that a reader or a check makes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How much a finding matters."""

    REMARK = "remark"
    """An estimate is worth less for it, and still is one."""
    NOT_MEANT = "not meant"
    """An estimate is not that of the pen: its numbers cannot be meant."""


@dataclass(frozen=True)
class Finding:
    """Something that an estimate may suffer from.

    Parameters
    ----------
    what : in words: ``the accelerometer has no gravity in it``
    where : file, columns or sensor: ``accel``
    sure : how sure that is, 0 to 1
    remedy : what to do; what is to be pasted into a pen file stands in its last lines
    severity : whether an estimate can still be meant
    span_s : from when to when it is so; None for all the time
    check : name of the check that found it, of `recordings.checks.table.CHECKS`; empty of a reader
    """

    what: str
    where: str
    sure: float
    remedy: str
    severity: Severity = Severity.REMARK
    span_s: tuple[float, float] | None = None
    check: str = ""

    @property
    def place(self) -> str:
        """Where and when, in words."""
        if self.span_s is None:
            return self.where
        return f"{self.where}, {span_words(*self.span_s)}"

    def sentence(self) -> str:
        """Return it as one sentence, with lines to paste below it where there are some."""
        how = "" if self.sure > 0.9 else ", probably"
        return f"{self.place}: {self.what}{how}; {self.remedy}"


def span_words(start_s: float, end_s: float) -> str:
    """Return a span in words: a phone counts from when it was switched on, ``88123.4 s``."""
    start, end = (f"{t:.4g}" if abs(t) < 100 else f"{round(t, 2):.12g}" for t in (start_s, end_s))
    return f"{start} s to {end} s"


def not_meant(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings for which an estimate cannot be meant."""
    return [finding for finding in findings if finding.severity is Severity.NOT_MEANT]


def in_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings, those first for which no estimate can be meant."""
    return tuple(sorted(findings, key=lambda one: one.severity is not Severity.NOT_MEANT))


def finding_lines(finding: Finding) -> list[str]:
    """Return a finding as lines: what it is, and below it what to do."""
    how = "" if finding.sure > 0.9 else f" ({finding.sure:.0%} sure)"
    first = f"{finding.severity.value.upper()}, {finding.check or 'reader'}: {finding.place}{how}"
    what, *more = finding.remedy.split("\n")
    return [first, f"  {finding.what}", f"  -> {what}", *(f"     {line}" for line in more)]
