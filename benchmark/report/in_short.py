"""The answer in short: per quantity and budget what to take, and whether optimising pays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from benchmark.report.advice import NO, OPEN, WITH, WITHOUT, YES, Pick, listed
from benchmark.report.numbers import count

if TYPE_CHECKING:
    from benchmark.report.content import Answer


def in_short(answers: Sequence[Answer]) -> list[tuple[str, ...]]:
    """Return a row of text per quantity and budget: what it is, and what to take."""
    return [
        (
            answer.matrix.quantity,
            pick.budget,
            pick.sensors or pick.why,
            pick.estimator or "–",
            pick.figure or "–",
            f"{pick.pays}: {pick.why}" if pick.sensors else "–",
        )
        for answer in answers
        for pick in answer.advice.picks
    ]


def headlines(answers: Sequence[Answer]) -> list[str]:
    """Return a sentence per budget, and one that says how often optimising pays."""
    found = [said for budget in (WITH, WITHOUT) if (said := _headline(answers, budget))]
    found += _not_told_apart(answers)
    picks = [(name, pick.pays) for name, pick in _named(answers) if pick.sensors]
    if not picks:
        return found
    paying, unknown = ([name for name, pays in picks if pays == word] for word in (YES, OPEN))
    if len(unknown) == len(picks):
        why = "this run has too few seeds, or estimators of one kind only"
        return [*found, f"Whether optimising pays is open: {why}."]
    said = f"Optimising pays in {len(paying) or 'none'} of these {count(len(picks), 'choice')}"
    if paying:
        said += f": for {listed(paying)}"
    if unknown:
        said += f"; it is open for {listed(unknown)}"
    if not paying and all(pays == NO for _, pays in picks):
        said += ": nothing shows the EKF worse there, and it is cheaper"
    return [*found, f"{said}."]


def _named(answers: Sequence[Answer]) -> list[tuple[str, Pick]]:
    """Return every pick behind its quantity and budget in words."""
    return [
        (f"{answer.matrix.quantity} {pick.budget}", pick)
        for answer in answers
        for pick in answer.advice.picks
    ]


def _headline(answers: Sequence[Answer], budget: str) -> str:
    taken: dict[str, list[str]] = {}
    for answer in answers:
        if pick := answer.advice.of(budget):
            what = f"{pick.sensors} with {pick.estimator}" if pick.sensors else ""
            taken.setdefault(what, []).append(answer.matrix.quantity)
    blind = taken.pop("", [])
    words = [f"{what} for {listed(names)}" for what, names in taken.items()]
    parts = [f"take {'; '.join(words)}"] if words else []
    if blind:
        parts.append(f"{listed(blind)} cannot be observed")
    return f"{budget[:1].upper()}{budget[1:]}: {'; '.join(parts)}." if parts else ""


def _not_told_apart(answers: Sequence[Answer]) -> list[str]:
    """Say for which quantities a cheaper choice of sensors may be as good."""
    unsure = [(name, pick) for name, pick in _named(answers) if pick.as_good]
    if not unsure:
        return []
    seeds = unsure[0][1].seeds
    if seeds == 1:
        return ["One seed does not tell whether cheaper sensors are as good."]
    what = listed([f"{name} ({listed([*pick.as_good])})" for name, pick in unsure])
    cheaper = f"By {seeds} seeds cheaper sensors are not surely worse"
    return [f"{cheaper} for {what}: more seeds would tell."]
