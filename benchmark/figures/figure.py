"""A figure as data: what it shows, whoever draws it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from models.arrays import Array

Style = Literal["line", "dashed", "points"]


@dataclass(frozen=True, eq=False)
class Line:
    """One curve.

    Parameters
    ----------
    name : in the legend, and of its colour: one name has one colour in the whole report
    x, y : (n,); NaN leaves a gap
    std : (n,) standard deviation; ±2 of it are drawn as a band. None draws none
    low, high : (n,) ends of an interval, drawn as error bars; None draws none
    style : points are not joined
    band : lower and upper end (n,) of a band, in place of that of `std`
    """

    name: str
    x: Array
    y: Array
    std: Array | None = None
    low: Array | None = None
    high: Array | None = None
    style: Style = "line"
    band: tuple[Array, Array] | None = None


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Parameters
    ----------
    title : above it
    x_label, y_label : with units
    lines : the first ones are drawn below
    x_log, y_log : logarithmic axes
    equal : one unit is as long on both axes: paths on paper
    own_x : its x axis is its own, whatever the panels of its column have
    """

    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    x_log: bool = False
    y_log: bool = False
    equal: bool = False
    own_x: bool = False


@dataclass(frozen=True, eq=False)
class Figure:
    """Panels that are read together.

    Parameters
    ----------
    key : for file names and links: ``pen-figure-4``
    title : what is to be seen
    caption : sentences: how it was made, what to look at
    panels : by rows; panels of one column share their x axis where their labels agree, see `own_x`
    columns : number of panels beside each other
    """

    key: str
    title: str
    caption: str
    panels: Sequence[Panel]
    columns: int = 1


TRUTH = "truth"
"""Name of the true curve."""

Table = tuple[str, str, Sequence[str], Sequence[Sequence[str]]]
"""Title, caption, names of the columns, and rows of text."""
