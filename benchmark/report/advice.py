"""One piece of advice per quantity, by rule from the numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmark.report.choice import (
    ENOUGH,
    NO_INTERVAL,
    OPTIMISING,
    chosen_estimator,
    is_unseen,
    reliable,
)
from benchmark.report.matrix import NOT_OBSERVABLE, Matrix
from benchmark.report.numbers import number
from benchmark.report.tied import Choice, tied

WITH, WITHOUT = "with a camera", "without a camera"
YES, NO, OPEN = "yes", "no", "open"
"""Whether optimising pays."""


@dataclass(frozen=True)
class Pick:
    """What to take for a quantity on a budget.

    Parameters
    ----------
    budget : `WITH` or `WITHOUT`; with a camera, its sensors may still be without
    sensors, estimator, figure : empty where nothing shows the quantity
    pays : whether an MHE pays with these sensors
    why : of the estimator
    cheaper : the cheapest sensors that show the quantity, where they are others
    as_good : cheaper sensors that the seeds of the run do not tell apart from these
    seeds : how many that are; what one seed does not tell is said once, by `in_short.headlines`
    """

    budget: str
    sensors: str = ""
    estimator: str = ""
    figure: str = ""
    pays: str = OPEN
    why: str = ""
    cheaper: str = ""
    as_good: tuple[str, ...] = ()
    seeds: int = 0

    @property
    def sentence(self) -> str:
        """Say what to take, and why."""
        if not self.sensors:
            return f"{self.why.capitalize()}."
        cheaper = f" Cheapest that shows it: {self.cheaper}." if self.cheaper else ""
        between = ";" if self.why == _ONE_SIDE else ":"
        unsure = (
            f" Not told apart from it by {self.seeds} seeds: {listed([*self.as_good])}; "
            "more seeds would tell."
            if self.as_good and self.seeds > 1
            else ""
        )
        return (
            f"Take {self.sensors} with {self.estimator} ({self.figure}){between} "
            f"{self.why}.{unsure}{cheaper}"
        )


_ONE_SIDE = "whether an MHE pays is open, because no run has both EKF and MHE"


@dataclass(frozen=True)
class Advice:
    """What to take, a pick for every budget that the run knows of, and what else there is."""

    picks: Sequence[Pick]
    more: str

    def of(self, budget: str) -> Pick | None:
        """Return the pick of a budget, if there is one."""
        return next((pick for pick in self.picks if pick.budget == budget), None)


def advice(matrix: Matrix) -> Advice:
    """Say what to take for a quantity, whether the MHE pays there, and what is next.

    1. An estimator whose worst seed is far beyond another's with the same sensors
       (`benchmark.report.choice.is_far_beyond`) is named nowhere but as such.
    2. With a camera, the sensors are those of the smallest median RMSE, whichever estimator
       has it. Without one they are the cheapest whose median is about as good as the smallest;
       the cheapest that show the quantity at all are named beside them. Cheaper ones that the
       seeds do not tell apart from them (`benchmark.report.tied.tied`) are named as such.
    3. With them, an MHE pays where its RMSE, run by run, is below the EKF's with 95 %
       confidence, and by more than one percent. Else the EKF is to be taken. Which MHE: the
       cheapest whose median is about as good as the best one's.
    4. Next are the sensors with the smallest median RMSE among the others.
    """
    ranked = _ranked(matrix, matrix.sensors)
    if not ranked:
        return Advice((), "Nothing in this run gives it: there is nothing to advise.")
    sentences = []
    if len(ranked) > 1:
        first, other = ranked[:2]
        median = first.cell.median
        times = f" ({number(other.cell.median / median)} times)" if median else ""
        sentences.append(
            f"Next: {other.sensors}, {number(other.cell.median)} {matrix.unit} with "
            f"{other.estimator}{times}."
        )
    if blind := [name for name in matrix.sensors if is_unseen(matrix, name, NOT_OBSERVABLE)]:
        words = listed([_in_words(matrix, name) for name in blind])
        sentences.append(f"{words[:1].upper()}{words[1:]}: not observable.")
    table = matrix.configurations
    cameras = any(name not in table or table[name].needs_camera for name in matrix.sensors)
    picks = [_pick(matrix, WITH, ranked[0], ranked[0], ranked)] if cameras else []
    return Advice([*picks, *_without_camera(matrix, ranked[0])], " ".join(sentences))


def _ranked(matrix: Matrix, among: Sequence[str]) -> list[Choice]:
    """Return the best reliable estimator of every configuration that has one, the best first."""
    found = []
    for sensors in among:
        if cells := reliable(matrix, sensors):
            name, cell = min(cells.items(), key=lambda entry: entry[1].median)
            found.append(Choice(sensors, name, cell))
    return sorted(found, key=lambda choice: choice.cell.median)


def _pick(
    matrix: Matrix,
    budget: str,
    choice: Choice,
    best: Choice,
    among: Sequence[Choice],
    *,
    cheaper: str = "",
) -> Pick:
    """Return what to take: a choice, one of those of the budget; the best is of all budgets."""
    take, why = chosen_estimator(matrix, choice.sensors)
    pays = YES if take in OPTIMISING else OPEN if not why or NO_INTERVAL in why else NO
    take, why = (take, why) if why else (choice.estimator, _ONE_SIDE)
    figure = _figure(matrix, choice.sensors, take, best)
    as_good = _cheaper_and_tied(matrix, choice, among)
    seeds = choice.cell.seeds
    return Pick(budget, choice.sensors, take, figure, pays, why, cheaper, as_good, seeds)


def _cheaper_and_tied(matrix: Matrix, choice: Choice, among: Sequence[Choice]) -> tuple[str, ...]:
    """Return the sensors that come before a choice, from cheap to dear, and are tied with it."""
    order = {name: place for place, name in enumerate(matrix.configurations)}
    others = [other for other in among if other.sensors != choice.sensors]
    found = {other.sensors for other in tied(matrix, choice, others)}
    own = order.get(choice.sensors, len(order))
    return tuple(name for name, place in order.items() if name in found and place < own)


def _without_camera(matrix: Matrix, best: Choice) -> list[Pick]:
    """Return what to take without a camera, if the run has sensors for it."""
    table = matrix.configurations
    known = [name for name in table if name in matrix.sensors]
    among = [name for name in known if not table[name].needs_camera]
    ranked = _ranked(matrix, among)
    if not ranked:
        blind = among and all(is_unseen(matrix, name, NOT_OBSERVABLE) for name in among)
        return [Pick(WITHOUT, pays=NO, why="not observable")] if blind else []
    cheapest = min(ranked, key=lambda choice: among.index(choice.sensors))
    good = [c for c in ranked if c.cell.median <= ENOUGH * ranked[0].cell.median]
    better = min(good, key=lambda choice: among.index(choice.sensors))
    cheaper = ""
    if better.sensors != cheapest.sensors:
        take = chosen_estimator(matrix, cheapest.sensors)[0] or cheapest.estimator
        figure = _figure(matrix, cheapest.sensors, take, best)
        cheaper = f"{cheapest.sensors} with {take} ({figure})"
    return [_pick(matrix, WITHOUT, better, best, ranked, cheaper=cheaper)]


def _figure(matrix: Matrix, sensors: str, estimator: str, best: Choice) -> str:
    """Return ``0.8 deg, 3.00 times the best``."""
    median = matrix.cell(sensors, estimator).median
    times = ""
    if sensors != best.sensors and best.cell.median:
        times = f", {number(median / best.cell.median)} times the best"
    return f"{number(median)} {matrix.unit}{times}"


def _in_words(matrix: Matrix, sensors: str) -> str:
    """Return ``gyroscope alone`` for one sensor, the name of a choice of several."""
    row = matrix.configurations.get(sensors)
    return sensors if row is None or len(row.sensors) > 1 else f"{row.label} alone"


def listed(names: list[str]) -> str:
    """Return ``a, b and c``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
