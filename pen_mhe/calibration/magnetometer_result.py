"""What turns of a pen said of its magnetometers, and a pen file that has it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from models.pen_config import PenConfig
from models.sensor_model import quantiser_variance
from pen_mhe.calibration.length import N_BIAS, PARAMETERS, LengthFit
from pen_mhe.calibration.noted import number_table, with_numbers
from pen_mhe.calibration.sensor_result import CalibratedNumber
from pen_mhe.tuning.new_pen_file import NewPenFile
from pen_mhe.tuning.parameters import SENSORS, Parameter
from pen_mhe.tuning.pen_text import PenText

if TYPE_CHECKING:
    import pandas as pd

DIP_RAD = math.radians(2.0)
"""A dip that differs by more from the pen file's is worth a sentence."""


@dataclass(frozen=True, eq=False)
class CalibratedMagnetometer:
    """What was found of one magnetometer.

    Parameters
    ----------
    sensor : as the pen file has it
    fit : bias in µT
    off_before_ut : how far |B| was off the field's strength with the file's numbers, RMS
    noise_ut : standard deviation of a reading in each axis
    n_noise : numbers that it was found from
    dip_rad : of the field and its deviation from reading to reading, where gravity tells it
    """

    name: str
    sensor: Any
    fit: LengthFit
    off_before_ut: float
    noise_ut: float
    n_noise: int
    dip_rad: tuple[float, float] | None

    @property
    def bias_std(self) -> float:
        """What the hard iron is known to, the least known axis, µT."""
        return float(np.hypot(self.fit.std[:N_BIAS].max(), self.fit.misfit_std))

    def numbers(self) -> Iterator[CalibratedNumber]:
        """Yield what was found."""
        found = zip(PARAMETERS, self.fit.values, self.fit.std, strict=True)
        for i, (quantity, value, std) in enumerate(found):
            is_scale = quantity.startswith("scale")
            unit = "µT" if i < N_BIAS else "" if is_scale else "rad"
            yield CalibratedNumber(self.name, quantity, unit, float(value) + is_scale, float(std))
        # Of second differences, whose neighbours share readings.
        std = self.noise_ut * math.sqrt(1.94 / (2 * self.n_noise))
        yield CalibratedNumber(self.name, "noise", "µT", self.noise_ut, std)

    def values(self) -> dict[Parameter, Any]:
        """Return what a pen file is told."""
        rows = self.fit.sensitivity.tolist()
        found: dict[str, Any] = {
            "bias_ut": tuple(map(float, self.fit.bias)),
            "sensitivity": tuple(tuple(row) for row in rows),
        }
        if self.sensor.bias_states(self.name).names:
            found["bias_std_ut"] = self.bias_std
        drawn = self.noise_ut**2 - quantiser_variance(self.sensor.resolution)
        if drawn > 0:
            found["noise_std_ut"] = math.sqrt(drawn)
        return {Parameter("turns", (SENSORS, self.name), key): v for key, v in found.items()}

    def sentences(self) -> Iterator[str]:
        """Yield what a person should know."""
        after = float(np.sqrt(np.mean(self.fit.after**2)))
        said = (
            f"{self.name}: |B| is off {self.sensor.field_strength_ut:.4g} µT by "
            f"{self.off_before_ut:.3g} µT before, {after:.3g} after (RMS over "
            f"{len(self.fit.after)} readings; noise alone: {self.fit.expected_std:.3g})"
        )
        if self.fit.inflation > 1.1:
            said += f": deviations are {self.fit.inflation:.3g} times those of noise; iron nearby?"
        yield said
        if self.dip_rad is not None:
            dip, spread = np.degrees(self.dip_rad)
            told = math.degrees(self.sensor.field_dip_rad)
            said = (
                f"{self.name}: by gravity the field's dip is {dip:.1f}° (± {spread:.1f}° a reading)"
            )
            if abs(self.dip_rad[0] - self.sensor.field_dip_rad) > DIP_RAD:
                said += (
                    f", the pen file says {told:.1f}°: is field_dip right, "
                    "and sensor_to_body of both sensors?"
                )
            yield said


@dataclass(frozen=True, eq=False, repr=False)
class MagnetometerCalibration(NewPenFile):
    """What `pen_mhe.calibration.magnetometer.calibrate_magnetometer` returns.

    Parameters
    ----------
    pen : with the numbers that were found
    sensors : by name
    values : what the pen file is told
    """

    pen: PenConfig
    sensors: Mapping[str, CalibratedMagnetometer]
    recording_names: tuple[str, ...]
    pen_name: str
    values: Mapping[Parameter, Any]
    text: PenText | None

    @property
    def numbers(self) -> tuple[CalibratedNumber, ...]:
        """All that was found, sensor by sensor."""
        return tuple(number for each in self.sensors.values() for number in each.numbers())

    @property
    def command(self) -> str:
        """What does the same on a terminal."""
        words = ["pen-mhe", "calibrate", "magnetometer", *self.recording_names]
        return shlex.join([*words, "--pen", self.pen_name, "--sensors", ",".join(self.sensors)])

    @property
    def table(self) -> pd.DataFrame:
        """A row per number: value, deviation, unit."""
        return number_table(self.numbers)

    def sentences(self) -> list[str]:
        """Return how well the field's strength fits, and what is not known."""
        return [
            *(sentence for each in self.sensors.values() for sentence in each.sentences()),
            "scales are relative to field_strength_ut; hard iron is that of this pen as it was: "
            "another battery, cap or start moves it",
        ]

    def to_toml(self) -> str:
        """Return the pen file's text with the numbers, and a note on where they are from.

        Raises
        ------
        InputError
            If the pen did not come from a file, or its numbers cannot be replaced.
        """
        return with_numbers(
            self._of_file(),
            self.numbers,
            self.values,
            self.pen,
            title="turns set these numbers",
            command=self.command,
        )

    def __repr__(self) -> str:
        return "\n\n".join([self.table.to_string(float_format="{:.5g}".format), *self.sentences()])
