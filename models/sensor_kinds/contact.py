"""A switch in the tip: the height of a plane while the tip touches it."""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import PositiveFloat

from models.sensor_kinds.mounted import NonNegative, SensorBase
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class Contact(SensorBase):
    """The tip touches a plane of known height while the pen presses.

    Its reading is the height of the plane, m, while the tip touches, and
    missing while it does not.

    Parameters
    ----------
    std_m : how well the tip keeps to the plane, m; larger trusts it less
    pressure_threshold : raw pressure above which a recording counts as touching
    """

    reads_touch: ClassVar[bool] = True
    kind: Literal["contact"] = "contact"
    height_m: float = 0.0
    std_m: PositiveFloat
    pressure_threshold: NonNegative = 0.0

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The height."""
        return (("z", "m"),)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the tip's height."""
        noise_std = np.array([self.std_m])
        return SymbolicReading(body.rigid.tip[2], noise_std, touched_height=self.height_m)
