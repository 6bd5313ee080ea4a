"""The paper that a pen writes on, as constraints on its tip.

    tip_z ≥ height + slope · (tip_x, tip_y)                      always
    tip_z ≤ height + slope · (tip_x, tip_y) + touch tolerance    where a contact sensor reads

A contact sensor's own noise says the second softly, and below as well as above the paper; both
may hold at once. Where the constraint alone shall hold, give the contact a `std_m` that says
nothing (1 m). A Kalman filter obeys no constraint: it has the reading.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from pydantic import PositiveFloat

from models.config import UnitConfig
from models.level import Vector2
from models.plane import LEVEL_PLANE, height_over
from models.state_space import StateSpaceModel

TIP_HEIGHT = "tip_z_m"
"""The state that the paper bounds."""


class Paper(UnitConfig):
    """A plane that the tip may touch and never passes.

    Parameters
    ----------
    height_m : the tip is never below it
    slope : rise of the paper along x and y, m per m, with `height_m` at x = y = 0; None takes
        that of the pen's contact sensors, or none
    touch_tolerance_m : while a contact sensor reads, the tip is at most this far above the
        paper; larger holds it less, None does not hold it; not used without such a sensor
    """

    height_m: float = 0.0
    slope: Vector2 | None = None
    touch_tolerance_m: PositiveFloat | None = None

    @property
    def highest_touching_m(self) -> float:
        """Height above which the tip does not touch; inf without a tolerance."""
        tolerance = self.touch_tolerance_m
        return math.inf if tolerance is None else self.height_m + tolerance


def above_paper(
    model: StateSpaceModel, paper: Paper, *, sensors: Mapping[str, Any] = MappingProxyType({})
) -> StateSpaceModel:
    """Return a copy of a pen's model that is held above its paper, and to it while it touches.

    Parameters
    ----------
    sensors : all that the pen has, see `slope_of`
    """
    tip, slope = model.state_names.index(TIP_HEIGHT), slope_of(paper, sensors)
    place = slice(tip - 2, tip + 1)
    if slope == LEVEL_PLANE:
        model = model.bounded(**{TIP_HEIGHT: (paper.height_m, float(model.upper[tip]))})
    else:
        model = model.constrained(lambda x: paper.height_m - height_over(x[place], slope))
    if paper.touch_tolerance_m is None:
        return model
    for sensor in model.sensors:
        if sensor.touched_height is not None:
            readings = [f"{sensor.name}_{axis}" for axis in sensor.axes]
            model = model.constrained(
                lambda x: height_over(x[place], slope) - paper.highest_touching_m, readings
            )
    return model


def slope_of(paper: Paper, sensors: Mapping[str, Any]) -> Vector2:
    """Return a paper's slope: its own, or that of the first contact sensor, or none."""
    if paper.slope is not None:
        return paper.slope
    of_contacts = (sensor.slope for sensor in sensors.values() if sensor.reads_touch)
    return next(of_contacts, LEVEL_PLANE)


def check_paper(
    paper: Paper | None,
    bounds: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    *,
    sensors: Mapping[str, Any] = MappingProxyType({}),
    **_: Any,
) -> None:
    """Raise `ValueError` where a pen says twice, or two things, about where its tip may be.

    Parameters
    ----------
    paper : the pen's, if it has one
    bounds, sensors : fields of `models.pen_config.PenConfig`
    """
    if paper is None:
        return
    lower, upper = bounds.get(TIP_HEIGHT, (-math.inf, math.inf))
    if lower > -math.inf:
        raise ValueError(
            f"its height_m {paper.height_m:g} and the lower bound {lower:g} on {TIP_HEIGHT} say "
            "the same thing, expected one of them (-inf as the bound leaves it to the paper)"
        )
    if upper <= paper.height_m:
        raise ValueError(
            f"its height_m {paper.height_m:g} is not below the upper bound {upper:g} on "
            f"{TIP_HEIGHT}, expected room for the tip above the paper"
        )
    for name, sensor in sensors.items():
        if not sensor.reads_touch:
            continue
        if not paper.height_m <= sensor.height_m <= paper.highest_touching_m:
            raise ValueError(
                f"contact sensor {name} touches a plane at height_m {sensor.height_m:g}, expected "
                f"{paper.height_m:g} to {paper.highest_touching_m:g}: the paper's height to its "
                "touch tolerance above"
            )
        slope = slope_of(paper, sensors)
        if sensor.slope != slope:
            raise ValueError(
                f"contact sensor {name} touches a plane of slope {list(sensor.slope)}, expected "
                f"that of the paper: {list(slope)}"
            )
