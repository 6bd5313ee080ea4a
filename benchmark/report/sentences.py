"""Sentences that page and text share."""

from __future__ import annotations

from collections.abc import Mapping

from benchmark.report.content import Content, ReportPart
from benchmark.report.made_with import duration_s
from benchmark.report.numbers import count
from benchmark.verdicts.claims import Claim
from benchmark.verdicts.judge import (
    FAILS,
    HOLDS,
    NO_DATA,
    NOT_JUDGED,
    UNDECIDED,
    Judgement,
)
from benchmark.verdicts.paired import BETTER, EQUAL, SAME, WORSE
from benchmark.verdicts.written import Origin

FULL_SEEDS = 20

PAIR_SYMBOLS: Mapping[str, str] = {BETTER: "✓", WORSE: "✗", EQUAL: "=", SAME: "="}


def lead(content: Content) -> str:
    """Say how much was run."""
    tasks = sum(part.tasks for part in content.parts)
    broken = sum(len(row.seeds) for part in content.parts for row in part.broken)
    words = [f"{count(tasks, 'task')} of {count(len(content.parts), 'suite')}"]
    seeds, seconds = content.run.get("seeds"), duration_s(content.run)
    if isinstance(seeds, int):
        words.append(count(seeds, "seed"))
    if seconds is not None:
        minutes, rest = divmod(round(seconds), 60)
        words.append(f"{minutes} min {rest} s")
    said = ", ".join(words) + "."
    if broken:
        said += f" {count(broken, 'task')} ended without a full result; their reasons are below."
    return said


ANSWER_IS_ABOUT = (
    "A pen that spins, in the hand of a writer; its sensors' biases are estimated, and its "
    "estimators are told the hand that the pen file states."
)


def answer_is_about(content: Content) -> str:
    """Say which pen the answer is about."""
    return str(content.run.get("answer_is_about", ANSWER_IS_ABOUT))


def papers_world(content: Content) -> str:
    """Say what the matrices of the pen that cannot spin are, and what it costs to believe it."""
    said = (
        "The pen of [Pen] cannot spin about its axis, and that is information: the ratio of two "
        "measured rates then gives its elevation. No pen in a hand is like that."
    )
    if not content.belief:
        return said
    return f"{said} A pen that spins, estimated by the model that cannot:"


def verdict_sentence(content: Content) -> str:
    """Say how many claims hold."""
    counts, claims = content.counts(), len(content.judgements)
    if not claims:
        return "This run judges no claims."
    said = (
        f"Of {count(claims, 'claim')}, {_verb(counts[HOLDS], 'holds', 'hold')}, "
        f"{_verb(counts[FAILS], 'does not', 'do not')}, "
        f"{_verb(counts[UNDECIDED], 'is', 'are')} undecided"
    )
    if counts[NOT_JUDGED]:
        said += f", {_verb(counts[NOT_JUDGED], 'is', 'are')} not judged"
    if counts[NO_DATA]:
        said += f", and on {counts[NO_DATA]} this run has no data"
    return (
        f"{said}. Each was written down with its criterion before the first run, but for those "
        "whose source says that it was after it, and those whose criterion says when it was "
        "changed, and why; it is undecided where the 95 % interval of its "
        "figure crosses the criterion." + _few_seeds(content)
    )


def notes(claim: Claim, written: Mapping[str, Origin]) -> list[str]:
    """Say when a criterion was written and changed, its margin, and why it is not judged."""
    said = [f"Written in commit {written[claim.id]}"] if claim.id in written else []
    said += [f"Not judged: {claim.not_judged}"] if claim.not_judged else []
    if claim.margin > 0:
        said.append(f"Of a single run, with a margin of {claim.margin:.0%}")
    return [*said, *(f"Changed on {change.on}: {change.why}" for change in claim.changed)]


def _few_seeds(content: Content) -> str:
    seeds = content.run.get("seeds")
    if not isinstance(seeds, int) or seeds >= FULL_SEEDS:
        return ""
    return (
        f" Intervals of {seeds} seeds are too short, those of five cover 84 % instead of 95; "
        f"{FULL_SEEDS} seeds are the full run."
    )


def _verb(n: int, one: str, more: str) -> str:
    return f"{n} {one if n == 1 else more}"


def refuted(content: Content) -> list[tuple[ReportPart, Judgement]]:
    """Return the claims that do not hold."""
    return [(p, found) for p in content.parts for found in p.judgements if found.verdict == FAILS]
