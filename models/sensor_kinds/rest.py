"""A pen at rest, as a reading of zero angular rate."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, PositiveFloat

from models.sensor_kinds.mounted import SensorBase
from models.sensor_kinds.reading import MovingBody, SymbolicReading
from models.sensor_model import RestRule


class Rest(SensorBase):
    """The angular rate is N(0, std²) per axis of the body while the pen rests.

    Whether it does is found from the readings of accelerometers and gyroscopes, see
    `estimation.rest`. Without it a still pen's bias about the vertical and a slow turn are
    one, and an estimator gains false confidence in its tilt from the turn that it believes in.

    Parameters
    ----------
    std_rad_s : how still a resting pen is, rad/s; larger learns biases from rest more slowly
    window_s : how long the pen must have been still, s; longer misses short rests, and takes
        fewer slow turns for rest
    spread_factor : by how many times its noise an inertial reading may spread; larger takes more
        trembling for rest
    largest_bias_rad_s : a mean rate beyond this is a turn; larger takes faster turns for bias.
        None takes `estimation.rest.LARGEST_BIAS` deviations of each gyroscope's bias
    is_detected : False takes rest from readings of its own: zero where an IMU says that it
        does not move, nothing elsewhere
    """

    is_rest: ClassVar[bool] = True
    kind: Literal["rest"] = "rest"
    std_rad_s: PositiveFloat = 0.0005
    window_s: PositiveFloat = 1.0
    spread_factor: Annotated[float, Field(gt=1)] = 2.5
    largest_bias_rad_s: PositiveFloat | None = None
    is_detected: bool = True

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """The body's axes."""
        return tuple((axis, "rad_s") for axis in "xyz")

    @property
    def makes_readings(self) -> bool:
        """Where it is detected."""
        return self.is_detected

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return the body's rate, without a bias."""
        rule = RestRule(self.window_s, self.spread_factor, self.largest_bias_rad_s)
        return SymbolicReading(
            body.rigid.body_rate(),
            np.full(3, self.std_rad_s),
            rest=rule if self.is_detected else None,
        )
