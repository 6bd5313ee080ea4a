"""Check: does a sensor repeat one reading?"""

from __future__ import annotations

from collections.abc import Iterator

from recordings.checks.looked import Looked
from recordings.finding import Finding, Severity

BRIEF_S, BRIEF = 2.0, 0.1
"""A sensor that is stuck for longer, or for more of the time, is not only to be remarked."""


def check_stuck(looked: Looked) -> Iterator[Finding]:
    """Find runs of one reading that are no rest; see `recordings.checks.repeats`."""
    for name, runs in looked.stuck.items():
        if not runs:
            continue
        time_s, values = looked.raw[name]
        longest = max(runs, key=lambda run: run.stop_s - run.start_s)
        stuck_s = sum(run.stop_s - run.start_s for run in runs)
        part = stuck_s / float(time_s[-1] - time_s[0])
        at = ", ".join(f"{value:.4g}" for value in values[longest.first])
        to_the_end = longest.end == len(values)
        many = "" if len(runs) == 1 else f", {len(runs)} times, {stuck_s:.3g} s in all"
        yield Finding(
            f"it is stuck: it repeats ({at}) for {longest.stop_s - longest.start_s:.3g} s"
            + (", to the end" if to_the_end else "")
            + many,
            name,
            0.99,
            "its bus or logger hung; record anew, or use what was before (--duration "
            f"{max(longest.start_s - float(time_s[0]), 0.0):.3g})",
            Severity.NOT_MEANT if part > BRIEF or stuck_s > BRIEF_S else Severity.REMARK,
            (longest.start_s, longest.stop_s),
        )
