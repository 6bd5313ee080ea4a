"""Where the tip is: a tablet, ultrasound, motion capture."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat, model_validator

from models.level import Vector2
from models.plane import LEVEL_PLANE, height_over
from models.sensor_kinds.mounted import NonNegative, SensorBase
from models.sensor_kinds.reading import MovingBody, SymbolicReading
from models.sensor_model import quantiser_variance

Axis = Literal["x", "y", "z"]
_ROW: dict[Axis, int] = {"x": 0, "y": 1, "z": 2}


class TipPosition(SensorBase):
    """The tip along some axes of the world, m, which are those of the paper.

    A tablet reads x and y, ultrasound all three. A tablet that leans is a pen file's `level_rad`.

    Parameters
    ----------
    axes : which are read
    std_m : one deviation, or one for each axis; larger trusts it less
    resolution_m : step between readings; 0 for one that is fine
    hover_m : height of the tip over the plane from which on there is no reading; used by the
        simulator only. None reads wherever the tip is
    height_m, slope : of the plane, see `models.sensor_kinds.contact.Contact`
    """

    kind: Literal["tip_position"] = "tip_position"
    axes: Annotated[tuple[Axis, ...], Field(min_length=1)] = ("x", "y", "z")
    std_m: PositiveFloat | tuple[PositiveFloat, ...]
    resolution_m: NonNegative = 0.0
    hover_m: PositiveFloat | None = None
    height_m: float = 0.0
    slope: Vector2 = LEVEL_PLANE

    @model_validator(mode="after")
    def _an_axis_each(self) -> Self:
        if len(set(self.axes)) < len(self.axes):
            raise ValueError(f"expected each axis once, got {', '.join(self.axes)}")
        if isinstance(self.std_m, tuple) and len(self.std_m) != len(self.axes):
            raise ValueError(
                f"std_m has {len(self.std_m)} numbers for the axes {', '.join(self.axes)}, "
                "expected one, or one for each"
            )
        return self

    @property
    def sees_position(self) -> bool:
        """Whether all three axes are read."""
        return len(self.axes) == 3

    @property
    def may_be_silent(self) -> bool:
        """The tip may be away all the time."""
        return True

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """Those that are read."""
        return tuple((axis, "m") for axis in self.axes)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the tip along the axes."""
        tip, drawn = body.rigid.tip, np.broadcast_to(self.std_m, len(self.axes))
        over = height_over(tip, self.slope) - self.height_m
        return SymbolicReading(
            tip[[_ROW[axis] for axis in self.axes]],
            np.sqrt(drawn**2 + quantiser_variance(self.resolution_m)),
            resolution=self.resolution_m,
            seen=None if self.hover_m is None else self.hover_m - over,
        )
