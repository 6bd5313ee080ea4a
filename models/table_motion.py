"""Strokes on a turntable: each axis runs at its constant rate, or stands still.

    φ(t) = φ₀ + Σ legs s φ̇ᵢ (t within leg),   s ∈ {-1, 0, 1},   φ̇ᵢ ∈ rate ± tolerance

with one rate per axis and leg. Strokes are rows of ``models/turntables/strokes.toml``.

References
----------
[Pen], its table of motions; see `models.turntable`.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PositiveFloat, ValidationError

from models.arrays import Array
from models.config import UnitConfig
from models.errors import InputError
from models.turntable import TILTS, TurntableConfig

Run = Literal[-1, 0, 1]
"""Backwards, at rest, forwards."""


class TableMotion(UnitConfig):
    """A stroke.

    Parameters
    ----------
    description : for people
    start_rad : φ and θ at its start
    legs : (duration in s, run of φ, run of θ), one after the other
    """

    description: str
    start_rad: tuple[float, float]
    legs: Annotated[tuple[tuple[PositiveFloat, Run, Run], ...], Field(min_length=1)]

    @property
    def duration_s(self) -> float:
        """Of all legs."""
        return float(sum(duration for duration, *_ in self.legs))

    @property
    def corners_s(self) -> Array:
        """Instants at which a leg follows another: an axis starts, stops or turns."""
        return np.cumsum([duration for duration, *_ in self.legs])[:-1]

    @property
    def runs(self) -> Array:
        """(legs, 2) in -1, 0, 1."""
        return np.array([leg[1:] for leg in self.legs], dtype=float)


@cache
def table_motions() -> Mapping[str, TableMotion]:
    """Return the strokes of ``models/turntables/strokes.toml`` by name.

    Raises
    ------
    InputError
        If a stroke of the file is wrong.
    """
    text = (resources.files("models") / "turntables" / "strokes.toml").read_text("utf-8")
    found = {}
    for name, row in tomllib.loads(text).items():
        try:
            found[name] = TableMotion.model_validate(row)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            key = ".".join(str(part) for part in first["loc"]) or "(all keys)"
            message = first["msg"].removeprefix("Value error, ")
            raise InputError(
                f"models/turntables/strokes.toml: stroke {name}: key {key}: {message}"
            ) from None
    return MappingProxyType(found)


def check_limits(table: TurntableConfig, motion: TableMotion) -> None:
    """Raise `InputError` where a stroke may leave the range of an axis, at any rate it may run."""
    durations = np.array([duration for duration, *_ in motion.legs])
    for column, (tilt, axis) in enumerate(zip(TILTS, table.axes, strict=True)):
        fastest = (axis.rate_rad_s + axis.rate_tolerance_rad_s) * motion.runs[:, column] * durations
        slowest = (axis.rate_rad_s - axis.rate_tolerance_rad_s) * motion.runs[:, column] * durations
        # The farthest it may get by the end of a leg, whatever the rates of the legs before.
        low = motion.start_rad[column] + np.cumsum(np.minimum(fastest, slowest))
        high = motion.start_rad[column] + np.cumsum(np.maximum(fastest, slowest))
        first, last = axis.range_rad
        reached = (
            min(motion.start_rad[column], low.min()),
            max(motion.start_rad[column], high.max()),
        )
        if reached[0] < first or reached[1] > last:
            raise InputError(
                f"stroke {motion.description}: {tilt} may reach {math.degrees(reached[0]):.1f} to "
                f"{math.degrees(reached[1]):.1f} deg, expected it within "
                f"{math.degrees(first):g} to {math.degrees(last):g} deg"
            )


def sample_table_motion(
    table: TurntableConfig, motion: TableMotion, time_s: Array, rng: np.random.Generator
) -> Array:
    """Return (φ, θ, φ̇, θ̇) (n, 4) at instants; at a corner the rates of the leg that begins.

    Parameters
    ----------
    time_s : (n,) increasing instants, s
    rng : draws the rate of each axis on each leg, evenly within its tolerance

    Raises
    ------
    InputError
        If the stroke may leave the table's range.
    """
    check_limits(table, motion)
    nominal = np.array([axis.rate_rad_s for axis in table.axes])
    tolerance = np.array([axis.rate_tolerance_rad_s for axis in table.axes])
    drawn = nominal + tolerance * rng.uniform(-1, 1, motion.runs.shape)
    rates = motion.runs * drawn
    starts = np.concatenate([[0.0], motion.corners_s])
    durations = np.array([duration for duration, *_ in motion.legs])
    at_start = motion.start_rad + np.vstack(
        [np.zeros(2), np.cumsum(rates * durations[:, None], axis=0)[:-1]]
    )
    leg = np.searchsorted(starts, time_s, side="right") - 1
    tilts = at_start[leg] + rates[leg] * (time_s - starts[leg])[:, None]
    return np.hstack([tilts, rates[leg]])
