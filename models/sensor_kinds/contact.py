"""A switch in the tip: the height of a plane, which may slope, while the tip touches it."""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import PositiveFloat

from models.level import Vector2
from models.plane import LEVEL_PLANE, height_over
from models.sensor_kinds.mounted import NonNegative, SensorBase
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class Contact(SensorBase):
    """The tip touches a known plane while the pen presses.

        z = height_m + slope · (x, y)

    Its reading is the height of the plane at x = y = 0, m, while the tip touches, and
    missing while it does not; it says where the tip is along z, less the plane's rise.
    `models.paper` says the same as a constraint.

    Parameters
    ----------
    slope : rise of the plane along x and y, m per m
    std_m : how well the tip keeps to the plane, m; larger trusts it less
    pressure_threshold : raw pressure above which a recording counts as touching
    pressure_baseline_s : the threshold is above the lowest pressure of so many seconds past, see
        `recordings.pressure`; longer follows a drift less, shorter takes a long press for it.
        None takes the raw pressure as it is
    """

    reads_touch: ClassVar[bool] = True
    kind: Literal["contact"] = "contact"
    height_m: float = 0.0
    slope: Vector2 = LEVEL_PLANE
    std_m: PositiveFloat
    pressure_threshold: NonNegative = 0.0
    pressure_baseline_s: PositiveFloat | None = None

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The height."""
        return (("z", "m"),)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the tip's height less the plane's rise from x = y = 0."""
        noise_std = np.array([self.std_m])
        height = height_over(body.rigid.tip, self.slope)
        return SymbolicReading(height, noise_std, touched_height=self.height_m)
