"""From the counts of a converter to accelerations in g, and back.

    V = ADC · Vref / (2^bits - 1)                                                          (1)
    offset = V - V_zero_g                                                                  (2)
    a = offset / S                                                                         (3)

References
----------
[Tilt] (1)-(3); (1) re-derived.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from models.arrays import Array
from models.errors import InputError

MOST_BITS = 32


@dataclass(frozen=True)
class AdcConversion:
    """An analogue accelerometer behind a converter.

    Parameters
    ----------
    zero_g_v : V_zero_g, output at 0 g, from the sensor's data sheet, V: an error of it is
        one of every acceleration, error / S. By default half of 3.3 V
    reference_v : Vref, voltage of the largest count, V; larger is a wider range and larger
        steps
    sensitivity_v_per_g : S, V/g; larger is smaller steps and a narrower range
    bits : of the converter

    Raises
    ------
    InputError
        If a number makes no sense.
    """

    zero_g_v: float = 1.65
    reference_v: float = 5.0
    sensitivity_v_per_g: float = 0.4785
    bits: int = 16

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0 < value < np.inf:
                raise InputError(f"{field.name} is {value}, expected a positive number")
        if self.bits != int(self.bits) or self.bits > MOST_BITS:
            raise InputError(f"bits is {self.bits}, expected a whole number up to {MOST_BITS}")
        if not self.zero_g_v < self.reference_v:
            raise InputError(
                f"zero_g_v is {self.zero_g_v} V, expected less than reference_v, "
                f"{self.reference_v} V"
            )

    @property
    def largest_count(self) -> int:
        """2^bits - 1: the count of the reference voltage."""
        return int(2**self.bits - 1)

    @property
    def step_g(self) -> float:
        """Acceleration of one count, g."""
        return self.reference_v / self.largest_count / self.sensitivity_v_per_g

    def acceleration_g(self, counts: ArrayLike) -> Array:
        """Return accelerations, g, of counts of any shape, equations (1)-(3).

        Raises
        ------
        InputError
            If a count is not a whole number that the converter has.
        """
        given = np.asarray(counts, dtype=float)
        # NaN is no whole number, and comparisons with it are false.
        wrong = ~((given >= 0) & (given <= self.largest_count) & (given == np.floor(given)))
        if wrong.any():
            raise InputError(
                f"count {given[wrong].flat[0]:g} of the converter, "
                f"expected a whole number from 0 to {self.largest_count}"
            )
        voltage = given * self.reference_v / self.largest_count
        offset = voltage - self.zero_g_v
        return np.asarray(offset / self.sensitivity_v_per_g)

    def counts(self, acceleration_g: ArrayLike) -> NDArray[np.int64]:
        """Return the counts that the converter gives for accelerations, g, of any shape.

        The nearest one; beyond its range the converter stays at its first or last count.

        Raises
        ------
        InputError
            If an acceleration is NaN: a converter always has a count.
        """
        given = np.asarray(acceleration_g, dtype=float)
        if np.isnan(given).any():
            raise InputError("an acceleration to convert is NaN, expected a number")
        voltage = self.zero_g_v + given * self.sensitivity_v_per_g
        nearest = np.round(voltage * self.largest_count / self.reference_v)
        return np.clip(nearest, 0, self.largest_count).astype(np.int64)
