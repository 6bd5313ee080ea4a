"""Minimum-jerk motion through via points, at rest in each.

    q(τ) = q₀ + (q₁ - q₀) (10 τ³ - 15 τ⁴ + 6 τ⁵),   τ = (t - t₀) / (t₁ - t₀)

References
----------
Flash, Hogan (1985), The coordination of arm movements: an experimentally
confirmed mathematical model, J. Neuroscience 5(7), 1688-1703.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from models.arrays import Array
from models.config import UnitConfig
from models.sensor_kinds.mounted import Vector3


class MinimumJerk(UnitConfig):
    """Via points of a motion.

    Parameters
    ----------
    description : what it draws
    time_s : (n,) when each point is reached, increasing
    tip_m : n tip positions
    angles_rad : n times azimuth, elevation, spin
    """

    kind: Literal["minimum_jerk"] = "minimum_jerk"
    description: str
    time_s: Annotated[tuple[float, ...], Field(min_length=2)]
    tip_m: tuple[Vector3, ...]
    angles_rad: tuple[Vector3, ...]

    @model_validator(mode="after")
    def _one_point_per_time(self) -> MinimumJerk:
        n = len(self.time_s)
        if not n == len(self.tip_m) == len(self.angles_rad):
            raise ValueError(
                f"expected one tip and one triple of angles per time, got {n} times, "
                f"{len(self.tip_m)} tips and {len(self.angles_rad)} triples"
            )
        if (np.diff(self.time_s) <= 0).any():
            raise ValueError("expected increasing times of the via points")
        return self


def minimum_jerk(via: MinimumJerk, time_s: Array) -> tuple[Array, Array, Array]:
    """Return q, q̇, q̈, each (n, 6), of the motion through via points.

    Before the first point and after the last the pen rests there.

    Parameters
    ----------
    time_s : (n,) sampling instants, s
    """
    knots = np.array(via.time_s)
    points = np.column_stack([np.array(via.tip_m), np.array(via.angles_rad)])
    clamped = np.clip(time_s, knots[0], knots[-1])
    segment = np.clip(np.searchsorted(knots, clamped, side="right") - 1, 0, len(knots) - 2)
    duration = np.diff(knots)[segment]
    tau = (clamped - knots[segment]) / duration
    reach = np.diff(points, axis=0)[segment]
    profile = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    speed = (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / duration
    acceleration = (60 * tau - 180 * tau**2 + 120 * tau**3) / duration**2
    return (
        points[segment] + reach * profile[:, None],
        reach * speed[:, None],
        reach * acceleration[:, None],
    )
