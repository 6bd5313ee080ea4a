"""Motions of a pen with exact derivatives: strokes as data, not as branches.

A motion gives the degrees of freedom q(t) and their first two derivatives in
closed form. A stroke runs through via points, at rest in each, with the
minimum-jerk profile of reaching movements:

    q(τ) = q₀ + (q₁ - q₀) (10 τ³ - 15 τ⁴ + 6 τ⁵),   τ = (t - t₀) / (t₁ - t₀)

References
----------
Flash, Hogan (1985), The coordination of arm movements, J. Neuroscience 5(7).
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType

import numpy as np

from models.arrays import Array
from models.config import UnitConfig
from models.errors import InputError


@dataclass(frozen=True, eq=False)
class Motion:
    """A sampled motion.

    Parameters
    ----------
    name : for people
    time_s : (n,)
    q, q_dot, q_ddot : (n, 6): tip, m, azimuth, elevation, spin, rad, and derivatives
    """

    name: str
    time_s: Array
    q: Array
    q_dot: Array
    q_ddot: Array


class Stroke(UnitConfig):
    """Via points of a stroke.

    Parameters
    ----------
    description : what it draws
    time_s : (n,) when each point is reached
    tip_m : n tip positions
    angles_rad : n times azimuth, elevation, spin
    """

    description: str
    time_s: tuple[float, ...]
    tip_m: tuple[tuple[float, float, float], ...]
    angles_rad: tuple[tuple[float, float, float], ...]


@cache
def strokes() -> Mapping[str, Stroke]:
    """Return the table of strokes, ``models/strokes.toml``, by name."""
    table = tomllib.loads((resources.files("models") / "strokes.toml").read_text("utf-8"))
    return MappingProxyType({name: Stroke.model_validate(row) for name, row in table.items()})


def stroke(name: str) -> Stroke:
    """Return a stroke by name; raises `InputError` for an unknown one."""
    if name not in strokes():
        raise InputError(f"stroke {name} is unknown, expected one of {', '.join(strokes())}")
    return strokes()[name]


def minimum_jerk(name: str, via: Stroke, time_s: Array) -> Motion:
    """Sample the minimum-jerk motion through a stroke's via points.

    Before the first point and after the last the pen rests there.

    Parameters
    ----------
    time_s : (n,) sampling instants, s
    """
    knots = np.array(via.time_s)
    points = np.column_stack([np.array(via.tip_m), np.array(via.angles_rad)])
    if len(knots) != len(points) or (np.diff(knots) <= 0).any():
        raise InputError(
            f"stroke {name}: expected one increasing time per via point, "
            f"got {len(knots)} times for {len(points)} points"
        )
    clamped = np.clip(time_s, knots[0], knots[-1])
    segment = np.clip(np.searchsorted(knots, clamped, side="right") - 1, 0, len(knots) - 2)
    duration = np.diff(knots)[segment]
    tau = (clamped - knots[segment]) / duration
    reach = np.diff(points, axis=0)[segment]
    profile = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    speed = (30 * tau**2 - 60 * tau**3 + 30 * tau**4) / duration
    acceleration = (60 * tau - 180 * tau**2 + 120 * tau**3) / duration**2
    return Motion(
        name,
        time_s,
        points[segment] + reach * profile[:, None],
        reach * speed[:, None],
        reach * acceleration[:, None],
    )
