"""The desk that a pen stays on, as a weak measurement of the tip."""

from __future__ import annotations

from typing import Literal

import casadi as ca
import numpy as np
from pydantic import PositiveFloat

from models.sensor_kinds.mounted import SensorBase, Vector3
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class WritingArea(SensorBase):
    """A pen stays on its desk: the tip is N(centre, std²) per axis at `rate_hz`.

    It has no readings of its own. It makes position observable where nothing
    else does; a larger `std_m` binds the tip less.
    """

    kind: Literal["writing_area"] = "writing_area"
    centre_m: Vector3 = (0.0, 0.0, 0.0)
    std_m: PositiveFloat = 1.0
    rate_hz: PositiveFloat | None = 100.0

    @property
    def sees_position(self) -> bool:
        """It bounds it, weakly."""
        return True

    @property
    def place_m(self) -> Vector3:
        """The centre."""
        return self.centre_m

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The tip's position."""
        return tuple((axis, "m") for axis in "xyz")

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the tip, whose constant reading is the centre."""
        centre = np.array(self.centre_m)
        return SymbolicReading(body.rigid.tip, np.full(3, self.std_m), constant_reading=centre)
