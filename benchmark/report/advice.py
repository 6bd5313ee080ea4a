"""One piece of advice per quantity, by rule from the numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmark.report.choice import ENOUGH, chosen_estimator, is_unseen, reliable
from benchmark.report.matrix import NOT_OBSERVABLE, Cell, Matrix
from benchmark.report.numbers import number


@dataclass(frozen=True)
class Advice:
    """What to take, in one sentence; what to take without a camera; what else there is."""

    take: str
    without_camera: str
    more: str


@dataclass(frozen=True)
class _Choice:
    """A choice of sensors with the reliable estimator of the smallest median."""

    sensors: str
    estimator: str
    cell: Cell


def advice(matrix: Matrix) -> Advice:
    """Say what to take for a quantity, whether the MHE pays there, and what is next.

    1. An estimator whose worst seed is far beyond another's with the same sensors
       (`benchmark.report.choice.is_far_beyond`) is named nowhere but as such.
    2. The sensors are those of the smallest median RMSE, whichever estimator has it.
    3. With them, an MHE pays where its RMSE, run by run, is below the EKF's with 95 %
       confidence, and by more than one percent. Else the EKF is to be taken. Which MHE: the
       cheapest whose median is about as good as the best one's.
    4. Without a camera: the cheapest sensors that show the quantity at all, with an estimator
       by the same rule; where it is another one, the cheapest that is about as good as the best.
    5. Next are the sensors with the smallest median RMSE among the others.
    """
    ranked = _ranked(matrix, matrix.sensors)
    if not ranked:
        return Advice("Nothing in this run gives it: there is nothing to advise.", "", "")
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
        words = _listed([_in_words(matrix, name) for name in blind])
        sentences.append(f"{words[:1].upper()}{words[1:]}: not observable.")
    return Advice(_take(matrix, ranked[0]), _without_camera(matrix, ranked[0]), " ".join(sentences))


def _ranked(matrix: Matrix, among: Sequence[str]) -> list[_Choice]:
    """Return the best reliable estimator of every configuration that has one, the best first."""
    found = []
    for sensors in among:
        if cells := reliable(matrix, sensors):
            name, cell = min(cells.items(), key=lambda entry: entry[1].median)
            found.append(_Choice(sensors, name, cell))
    return sorted(found, key=lambda choice: choice.cell.median)


def _take(matrix: Matrix, choice: _Choice) -> str:
    sensors, cells = choice.sensors, reliable(matrix, choice.sensors)
    take, why = chosen_estimator(matrix, sensors)
    if not why:
        take = choice.estimator
        why = "whether an MHE pays is open, because no run has both EKF and MHE"
        return f"Take {sensors} with {take} ({number(cells[take].median)} {matrix.unit}); {why}."
    return f"Take {sensors} with {take} ({number(cells[take].median)} {matrix.unit}): {why}."


def _without_camera(matrix: Matrix, best: _Choice) -> str:
    """Say what to take without a camera: the cheapest that shows it, and a better one if any."""
    table = matrix.configurations
    known = [name for name in table if name in matrix.sensors]
    among = [name for name in known if not table[name].needs_camera]
    ranked = _ranked(matrix, among)
    if not ranked:
        blind = among and all(is_unseen(matrix, name, NOT_OBSERVABLE) for name in among)
        return "Without a camera: not observable." if blind else ""
    cheapest = min(ranked, key=lambda choice: among.index(choice.sensors))
    said = f"Cheapest without a camera: {_named(matrix, cheapest, best)}"
    good = [c for c in ranked if c.cell.median <= ENOUGH * ranked[0].cell.median]
    better = min(good, key=lambda choice: among.index(choice.sensors))
    if better.sensors != cheapest.sensors:
        return f"{said}; best without: {_named(matrix, better, best)}."
    return f"{said}."


def _named(matrix: Matrix, choice: _Choice, best: _Choice) -> str:
    """Return ``accel+gyro with ekf (0.8 deg, 3 times the best)``."""
    take = chosen_estimator(matrix, choice.sensors)[0] or choice.estimator
    median = matrix.cell(choice.sensors, take).median
    times = ""
    if choice.sensors != best.sensors and best.cell.median:
        times = f", {number(median / best.cell.median)} times the best"
    return f"{choice.sensors} with {take} ({number(median)} {matrix.unit}{times})"


def _in_words(matrix: Matrix, sensors: str) -> str:
    """Return ``gyroscope alone`` for one sensor, the name of a choice of several."""
    row = matrix.configurations.get(sensors)
    return sensors if row is None or len(row.sensors) > 1 else f"{row.label} alone"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
