"""What a reader says on its way through a file."""

from __future__ import annotations

from dataclasses import dataclass, field

from recordings.finding import Finding


def counted(n: int, noun: str) -> str:
    """Return ``1 row`` or ``3 rows``."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


@dataclass(eq=False)
class Remarks:
    """Sentences on what was recognised or ignored, and on what was repaired."""

    notes: list[str] = field(default_factory=list)
    repairs: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
