"""When a claim's criterion was written: the commit that last touched a line of it.

Derived from the history of a checkout, so that nobody types it. Any touch counts, one of layout
too: a date can come out too late, never too early. Installed packages have no history.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

JUDGES = re.compile(
    r"(id|criterion|of|value|against|compare|statistic|every|at_least|at_most|margin)\s*="
)
"""Lines of a claim that decide its verdict."""
ID = re.compile(r'id\s*=\s*"([^"]+)"')
NOT_COMMITTED = "0" * 40


@dataclass(frozen=True)
class Origin:
    """A commit and its instant (UTC); an empty commit: the lines are not committed."""

    commit: str
    at: datetime

    def __str__(self) -> str:
        return f"{self.commit[:7]} of {self.at.date()}" if self.commit else "no commit yet"


def criteria_written(path: Path) -> Mapping[str, Origin]:
    """Return claim → when its criterion was written; nothing outside a checkout."""
    command = ["git", "blame", "--line-porcelain", "--", path.name]
    try:
        told = subprocess.run(command, cwd=path.parent, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return {}
    found: dict[str, Origin] = {}
    claim, commit, at = "", "", datetime.min.replace(tzinfo=UTC)
    for line in told.stdout.splitlines():
        if header := re.match(r"([0-9a-f]{40}) \d+ \d+", line):
            commit = header[1] if header[1] != NOT_COMMITTED else ""
        elif line.startswith("committer-time "):
            at = datetime.fromtimestamp(int(line.split()[1]), UTC)
        elif line.startswith("\t") and JUDGES.match(line[1:]):
            if named := ID.match(line[1:]):
                claim = named[1]
            if claim not in found or found[claim].at < at:
                found[claim] = Origin(commit, at)
    return found
