"""What a watch says of each sensor at a step: a bit mask, and the words of it."""

from __future__ import annotations

import enum
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Flags = NDArray[np.uint8]
"""Bit masks of `Flag`, one per sensor."""


class Flag(enum.IntFlag):
    """What can be said of one sensor at one step; several can hold at once, 0 means nothing."""

    STUCK = 1
    OUTLIER = 2
    INCONSISTENT = 4
    LEFT_OUT = 8

    @property
    def word(self) -> str:
        """Return a single flag as it is written to files."""
        return (self.name or "").lower()


def label(flags: Sequence[int] | Flags, sensor_names: Sequence[str]) -> str:
    """Return e.g. ``accel:stuck+camera:outlier``; empty where nothing is flagged.

    A sensor of which two things are said stands there twice: ``accel:stuck+accel:left_out``.

    Parameters
    ----------
    flags : (n_sensors,) bit masks
    sensor_names : (n_sensors,)
    """
    return "+".join(
        f"{name}:{flag.word}"
        for name, mask in zip(sensor_names, flags, strict=True)
        for flag in Flag(int(mask))
    )


def labels(flagged: Flags, sensor_names: Sequence[str]) -> list[str]:
    """Return the label of each step: (n, n_sensors) masks, of which few are different."""
    different, which = np.unique(flagged, axis=0, return_inverse=True)
    told = [label(flags, sensor_names) for flags in different]
    return [told[number] for number in which.ravel()]


def not_watched() -> Flags:
    """Return the flags of a step that nobody watched: of no sensor."""
    return _NOT_WATCHED


_NOT_WATCHED: Flags = np.zeros(0, dtype=np.uint8)
_NOT_WATCHED.flags.writeable = False
