"""Where the panels of a figure stand, and which of them share an x axis."""

from __future__ import annotations

from dataclasses import dataclass

from benchmark.figures.figure import Figure


@dataclass(frozen=True)
class Place:
    """One panel's place.

    Parameters
    ----------
    row, column : from 0, from the top left
    shares : number of the panel whose x axis it has; its own where it has one of its own
    shows_x : whether it carries labels at its x axis: no where the panel below has the same
    """

    row: int
    column: int
    shares: int
    shows_x: bool


def places(figure: Figure, columns: int | None = None) -> list[Place]:
    """Return the place of every panel.

    Panels of one column of the figure share their x axis where label and scale agree; paths
    on paper keep their own, because their axes are tied to each other.

    Parameters
    ----------
    columns : panels beside each other, other than the figure asks for: 1 on a phone. Which
        panels share an axis does not change by it
    """
    wide = max(figure.columns, 1)
    columns = wide if columns is None else columns
    first: dict[tuple[int, str, bool], int] = {}
    shares = []
    for number, panel in enumerate(figure.panels):
        if panel.equal or panel.own_x:
            shares.append(number)
        else:
            shares.append(first.setdefault((number % wide, panel.x_label, panel.x_log), number))
    found = []
    for number in range(len(shares)):
        below = number + columns
        hidden = below < len(shares) and shares[below] == shares[number]
        found.append(Place(number // columns, number % columns, shares[number], not hidden))
    return found
