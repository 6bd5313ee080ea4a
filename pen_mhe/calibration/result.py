"""What still poses said: numbers with their deviations, and a pen file that has them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.calibration.allan import EXTRA
from pen_mhe.calibration.gravity import different_poses
from pen_mhe.calibration.noted import number_table, with_numbers
from pen_mhe.calibration.sensor_result import CalibratedNumber, CalibratedSensor
from pen_mhe.calibration.stills import Stills
from pen_mhe.tuning.new_pen_file import NewPenFile
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText

if TYPE_CHECKING:
    import pandas as pd

NEEDED = f"they need pip install 'pen-mhe[{EXTRA}]'"


@dataclass(frozen=True, eq=False, repr=False)
class StillCalibration(NewPenFile):
    """What `pen_mhe.calibration.still.calibrate_still` returns.

    Parameters
    ----------
    pen : with the numbers that were found
    find : what was looked for
    stills : the stretches, and those that were left out
    sensors : by name
    values : what the pen file is told, SI
    has_noise : whether the library was there that noise levels need
    """

    pen: PenConfig
    find: str
    stills: Stills
    sensors: Mapping[str, CalibratedSensor]
    recording_names: tuple[str, ...]
    pen_name: str
    values: Mapping[Parameter, Any]
    text: PenText | None
    has_noise: bool

    @property
    def numbers(self) -> tuple[CalibratedNumber, ...]:
        """All that was found, sensor by sensor."""
        return tuple(number for each in self.sensors.values() for number in each.numbers())

    @property
    def command(self) -> str:
        """What does the same on a terminal."""
        words = ["pen-mhe", "calibrate", "still", *self.recording_names, "--pen", self.pen_name]
        return shlex.join([*words, "--sensors", ",".join(self.sensors), "--find", self.find])

    @property
    def table(self) -> pd.DataFrame:
        """A row per number: value, deviation, unit."""
        return number_table(self.numbers)

    def sentences(self) -> list[str]:
        """Return what was still, how well gravity fits, and what is not known."""
        kept = self.stills.kept
        shortest, *_, longest = sorted([still.duration_s for still in kept] * 2)
        lengths = f"{shortest:.3g} to {longest:.3g} s"
        said = [
            f"1 still stretch of {longest:.3g} s"
            if len(kept) == 1
            else f"{len(kept)} still stretches of {lengths}{self._poses()}"
        ]
        for how, left_out in (("creeps", self.stills.creeping), ("turns", self.stills.turning)):
            said += [
                f"left out: {still.recording} from {still.start_s:.4g} s to {still.stop_s:.4g} s, "
                f"which {how}"
                for still in left_out
            ]
        said += [sentence for each in self.sensors.values() for sentence in each.sentences()]
        if self.find != "noise":
            said.append("a bias is that of these recordings: another start or temperature moves it")
        if self.has_noise:
            said.append("noise is that at rest: a hand on paper adds to it, see pen-mhe tune")
        else:
            said.append(f"noise levels are left as they are: {NEEDED}")
        return said

    def _poses(self) -> str:
        for name, each in self.sensors.items():
            if each.gravity is not None:
                means = np.array([still.mean(name) for still in self.stills.kept])
                return f", {different_poses(means)} different poses"
        return ""

    def to_toml(self) -> str:
        """Return the pen file's text with the numbers, and a note on where they are from.

        Raises
        ------
        InputError
            If the pen did not come from a file, its numbers cannot be replaced, or nothing
            was found.
        """
        text = self._of_file()
        if not self.values:
            reason = "it is below the resolution" if self.has_noise else NEEDED
            raise InputError(f"{self.find}: nothing was found, {reason}; expected --find bias")
        return with_numbers(
            text,
            self.numbers,
            self.values,
            self.pen,
            title="still poses set these numbers",
            command=self.command,
        )

    def __repr__(self) -> str:
        return "\n\n".join([self.table.to_string(float_format="{:.5g}".format), *self.sentences()])
