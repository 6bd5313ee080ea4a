"""What is measured of an estimate of a gesture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmark.tasks.task import Quantity, Series
from models.arrays import Array
from suites.gyro_free.gesture import GestureMotion


@dataclass(frozen=True, eq=False)
class Estimated:
    """What an estimator says of a gesture.

    Parameters
    ----------
    rate : (n, 3) rad/s, axes with x along the pen
    C : (n, 3, 3) direction cosines, world to body
    position : (n, 3) of the centre of mass, m
    """

    rate: Array
    C: Array
    position: Array


def scores(
    motion: GestureMotion, estimated: Estimated, sees_roll: bool = True
) -> tuple[Quantity, ...]:
    """Return the errors of an estimate.

    ``rate``: of the two rates perpendicular to the axis; ``rate growth``: its RMS in the
    second half of the run over the first's; ``roll rate``: about the axis; ``attitude``:
    angle between the two frames; ``path``: distance; ``path end``: at the last instant, also
    by the length of the path.

    Parameters
    ----------
    sees_roll : False where the roll is taken for zero, and its error says nothing
    """
    rate = np.degrees(estimated.rate - motion.rate)
    away = estimated.position - motion.position
    length = np.linalg.norm(np.diff(motion.position, axis=0), axis=1).sum()
    end = float(np.linalg.norm(away[-1]))
    return (
        Quantity.of_errors("rate", "deg/s", rate[:, 1:]),
        Quantity.single("rate growth", "1", growth(rate[:, 1:])),
        Quantity.of_errors("roll rate", "deg/s", rate[:, 0], sees_roll),
        Quantity.of_errors("attitude", "deg", np.degrees(angle_between(estimated.C, motion.C))),
        Quantity.of_errors("path", "mm", 1e3 * away),
        Quantity.single("path end", "mm", 1e3 * end),
        Quantity.single("path end by length", "%", 100 * end / length),
    )


def growth(errors: Array) -> float:
    """Return the RMS of errors (n, k) in the second half over that in the first."""
    half = len(errors) // 2
    first, second = (
        np.sqrt((part**2).sum(axis=1).mean()) for part in (errors[:half], errors[half:])
    )
    return float(second / first) if first > 0 else float("inf" if second > 0 else "nan")


def angle_between(C: Array, other: Array) -> Array:
    """Return the angle (n,), rad, between two attitudes (n, 3, 3)."""
    # |R - I|² = 8 sin²(angle / 2): exact for small angles, where the trace is not.
    distance = np.linalg.norm(C - other, axis=(1, 2))
    return np.asarray(2 * np.arcsin(np.minimum(distance / np.sqrt(8), 1.0)))


def rate_series(time_s: Array, estimate: Array, truth: Array) -> tuple[Series, ...]:
    """Return both rates perpendicular to the axis over time; rates (n, 3) in rad/s."""
    return tuple(
        Series(
            f"rate {axis}",
            "deg/s",
            time_s,
            np.degrees(estimate[:, column]),
            truth=np.degrees(truth[:, column]),
        )
        for axis, column in (("y", 1), ("z", 2))
    )


def path_series(motion: GestureMotion, position: Array) -> tuple[Series, ...]:
    """Return the horizontal coordinates of the path over time."""
    return tuple(
        Series(
            f"path {axis}",
            "mm",
            motion.time_s,
            1e3 * position[:, column],
            truth=1e3 * motion.position[:, column],
        )
        for axis, column in (("x", 0), ("y", 1))
    )
