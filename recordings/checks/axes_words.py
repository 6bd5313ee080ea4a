"""Axes in words: which of a sensor's readings belong to which axis, with which sign."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from models.arrays import Array


def turned_axes(matrix: Array, names: Sequence[str] = ("x", "y", "z")) -> tuple[str, ...]:
    """Return for each true axis the reading that is along it: ``("-y", "x", "z")``.

    Parameters
    ----------
    matrix : (3, 3) near a signed permutation, v_true = matrix · v_read
    names : of the readings
    """
    found = []
    for row in matrix:
        at = int(np.argmax(np.abs(row)))
        found.append(f"{'-' if row[at] < 0 else ''}{names[at]}")
    return tuple(found)


def what_is_wrong(matrix: Array) -> str:
    """Say what a signed permutation does to axes: flips signs, swaps axes, or both."""
    axes = turned_axes(matrix)
    flipped = [axis[1:] for axis in axes if axis.startswith("-")]
    if [axis.lstrip("-") for axis in axes] == ["x", "y", "z"]:
        if len(flipped) == 3:
            return "its sign is flipped, on all three axes"
        noun = "sign" if len(flipped) == 1 else "signs"
        return (
            f"the {noun} of {' and '.join(flipped)} {'is' if len(flipped) == 1 else 'are'} flipped"
        )
    if not flipped:
        moved = [n for n, axis in zip("xyz", axes, strict=True) if axis != n]
        return (
            f"axes {' and '.join(moved)} are swapped" if len(moved) == 2 else "its axes are shifted"
        )
    return "its axes are turned or swapped"
