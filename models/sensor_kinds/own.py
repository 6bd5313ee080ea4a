"""A sensor of one's own on a pen: it stands in no file, and in no table of kinds."""

from __future__ import annotations

from typing import Any, Literal

import casadi as ca
from pydantic import ConfigDict

from models.own_noise import constant_noise
from models.own_sensors import OwnSensor, column, residual_of
from models.pen_quantities import PenQuantities
from models.sensor_kinds.mounted import NonNegative, SensorBase
from models.sensor_kinds.reading import BiasStates, MovingBody, SymbolicReading
from models.units import plain_unit


class OwnPenSensor(SensorBase):
    """What `models.attached_sensor.with_sensor` puts on a pen.

    Parameters
    ----------
    name : the sensor's
    own : what it reads; its `reads` takes `models.pen_quantities.PenQuantities`
    bias_std, bias_walk : of a bias state in each axis, in the unit of the axes; none where the
        first is 0
    holds_tip : whether the tip's position stays bounded with it
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)
    kind: Literal["own"] = "own"
    name: str
    own: OwnSensor
    bias_std: NonNegative = 0.0
    bias_walk: NonNegative = 0.0
    holds_tip: bool = False

    @property
    def sees_position(self) -> bool:
        """As was said of it."""
        return self.holds_tip

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """Its axes; a unit that `models.units` does not know stands as it is."""
        return tuple((axis, plain_unit(unit)) for axis, unit in self.own.axes.items())

    def bias_states(self, name: str) -> BiasStates:
        """Return a bias state per axis; none unless its initial std is positive."""
        if self.bias_std == 0:
            return BiasStates()
        axes, unit = self.reading_axes, self.reading_axes[0][1]
        names = tuple("_".join(filter(None, (name, "bias", axis, unit))) for axis, unit in axes)
        return BiasStates(names, unit, (0.0,) * len(axes), self.bias_std, self.bias_walk)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Return what it reads, its bias added."""
        n, where = len(self.own.axes), f"sensor {self.name}"
        per = f"axis ({', '.join(self.own.axes)})"
        reading: Any = self.own.reads(PenQuantities(body))
        h = column(reading, n, f"{where}: its reading", per)
        h = h + bias if bias.numel() else h
        std, whitening = constant_noise(self.name, self.own.noise_std, self.own.noise_covariance, n)

        def residual(y: ca.SX) -> ca.SX:
            r = column(residual_of(self.name, self.own, y, h), n, f"{where}: its residual", per)
            return r if whitening is None else ca.sparsify(ca.DM(whitening)) @ r

        return SymbolicReading(h, std, residual)
