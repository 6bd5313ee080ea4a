"""How a chip is mounted on a pen: which of its axes points from the tip to the top.

Two things tell. The lever (`recordings.checks.lever`): where the tip rests, it is the axis itself.
And gravity: a pen that writes stands more than it lies, so its axis is the one that is most
upright; that is a guess where two are about equally so. Neither tells the turn about the pen's
axis, which only adds to its spin: of the four ways the one nearest to a given mounting is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from recordings.checks.axes_fit import CANDIDATES
from recordings.checks.lever import Lever

RESTS = 0.93
"""Part of the changes of force that a lever explains, from which on the tip rests."""
NEAREST_M, FARTHEST_M = 0.004, 0.6
"""Lengths that a lever on a pen may have."""
PRECISION = 0.1
"""Standard error of a lever over its length, at most."""
MOUNTINGS = CANDIDATES[np.linalg.det(CANDIDATES) > 0]
"""The 24 proper ones, the identity first."""
HALF_G = 0.5
"""Part of the median |f| from which on a mean force points along gravity."""


@dataclass(frozen=True, eq=False)
class AxisEvidence:
    """Which way a pen's axis points, tip to top, in axes of a chip.

    Parameters
    ----------
    axis : (3,) the nearest of the six directions along the chip's axes
    sure : 0 to 1
    by_lever : whether the lever tells it; else gravity does
    """

    axis: Array
    sure: float
    by_lever: bool


def up_of(force: Array) -> Array | None:
    """Return the (3,) mean direction up in a chip's axes; None where there is no gravity.

    Parameters
    ----------
    force : (n, 3) specific force, any unit
    """
    mean = np.median(force, axis=0)
    norm, usual = np.linalg.norm(mean), np.median(np.linalg.norm(force, axis=1))
    return np.asarray(mean / norm) if norm > HALF_G * usual else None


def is_told(lever: Lever | None) -> bool:
    """Whether a lever tells the pen's axis: the tip rests, and it is known."""
    return (
        lever is not None
        and lever.explained > RESTS
        and NEAREST_M < lever.length_m < FARTHEST_M
        and float(lever.std_m.max()) < PRECISION * lever.length_m
    )


def axis_of(up: Array | None, lever: Lever | None) -> AxisEvidence | None:
    """Return which way the pen's axis points; None where nothing tells.

    Parameters
    ----------
    up : (3,) of `up_of`
    lever : in the same axes; None where there is none
    """
    if lever is not None and is_told(lever):
        return AxisEvidence(nearest_axis(lever.axis), 0.99, True)
    if up is None:
        return None
    size = np.sort(np.abs(up))
    # Of two axes alike either may be the pen's.
    return AxisEvidence(nearest_axis(up), float(np.clip(size[2] - size[1], 0.1, 0.9)), False)


def nearest_axis(direction: Array) -> Array:
    """Return the (3,) nearest of the six directions along the axes."""
    found = np.zeros(3)
    largest = int(np.argmax(np.abs(direction)))
    found[largest] = np.sign(direction[largest])
    return found


def mounting_of(axis: Array, like: Array | None = None) -> Array:
    """Return a (3, 3) rotation ``sensor_to_body`` that takes an axis of a chip to the pen's.

    Parameters
    ----------
    axis : (3,) one of the six directions along the chip's axes, which points from tip to top
    like : (3, 3) a mounting that it should be near to; the identity by default
    """
    near = np.eye(3) if like is None else like
    fitting = [M for M in MOUNTINGS if M[2] @ axis > 0.5]
    return np.asarray(max(fitting, key=lambda M: float(np.sum(M * near))))


def matrix_text(matrix: Array | Sequence[Sequence[float]]) -> str:
    """Write a matrix as a pen file has it: ``[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]``."""
    rows = [", ".join(f"{round(float(x), 6) + 0.0:g}" for x in row) for row in matrix]
    return f"[{', '.join(f'[{row}]' for row in rows)}]"
