"""What a camera's frames said of a pen: numbers with their deviations, and a pen file."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from models.pen_config import PenConfig
from models.version import version
from pen_mhe.calibration.camera_fit import Fit
from pen_mhe.calibration.mounting import OFFSET, MountingQuantity, Number
from pen_mhe.tuning.new_pen_file import NewPenFile
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText

if TYPE_CHECKING:
    import pandas as pd

APART = 3.0
"""Deviations between halves from which on they disagree."""


@dataclass(frozen=True)
class RateScore:
    """How well frames at one rate are predicted, mean nats a frame.

    Parameters
    ----------
    before, after : with the pen file's numbers, and with those that were found
    other_half : each half with what the other half found
    """

    rate_hz: float
    before: float
    after: float
    other_half: float


@dataclass(frozen=True)
class MountedNumber:
    """A number that was found, in its unit: a change of what the pen file says.

    Parameters
    ----------
    halves : (value, deviation) by the first half, and by the second
    """

    name: str
    unit: str
    value: float
    std: float
    halves: tuple[tuple[float, float], tuple[float, float]]

    @property
    def halves_apart(self) -> float:
        """By how many deviations of their difference the halves differ."""
        (a, a_std), (b, b_std) = self.halves
        return abs(a - b) / float((a_std**2 + b_std**2) ** 0.5)


@dataclass(frozen=True, eq=False, repr=False)
class CameraCalibration(NewPenFile):
    """What `pen_mhe.calibration.camera.calibrate_camera` returns.

    Parameters
    ----------
    pen : with the numbers that were found
    sensors : that were used
    numbers, fit, halves : all numbers; what was found of them, and by each half by itself
    whole : what was found with all of them free
    scores : by camera rate
    frame_count : how many frames count
    values : what the pen file is told, SI
    fixed : quantities that are the recording's own, and no pen file's
    delay_s : of the camera in the pen file
    """

    pen: PenConfig
    sensors: tuple[str, ...]
    numbers: tuple[Number, ...]
    fit: Fit
    whole: Fit
    halves: tuple[Fit, ...]
    scores: tuple[RateScore, ...]
    frame_count: int
    recording_name: str
    pen_name: str
    values: Mapping[Parameter, Any]
    fixed: frozenset[MountingQuantity]
    delay_s: float
    text: PenText | None

    @property
    def found(self) -> tuple[MountedNumber, ...]:
        """The numbers that are told, in their units."""
        found = []
        for i, number in enumerate(self.numbers):
            if self.fit.told[i]:
                factor = number.quantity.factor
                value, std = factor * self.fit.values[i], factor * self.fit.std[i]
                first, second = ((factor * h.values[i], factor * h.std[i]) for h in self.halves)
                unit = number.quantity.unit
                found.append(MountedNumber(number.name, unit, value, std, (first, second)))
        return tuple(found)

    @property
    def command(self) -> str:
        """What does the same on a terminal."""
        words = ["pen-mhe", "calibrate", "camera", self.recording_name, "--pen", self.pen_name]
        return shlex.join([*words, "--sensors", ",".join(self.sensors)])

    @property
    def table(self) -> pd.DataFrame:
        """A row per number: change, deviation, unit, and both by each half."""
        import pandas as pd

        rows = [(n.value, n.std, n.unit, *n.halves[0], *n.halves[1]) for n in self.found]
        columns = ["change", "std", "unit", "first half", "std 1", "second half", "std 2"]
        return pd.DataFrame(rows, index=[n.name for n in self.found], columns=columns)

    def sentences(self) -> list[str]:
        """Return what the numbers are worth, what disagrees, and what is not known."""
        said = [
            f"frames at {s.rate_hz:.3g} Hz: {s.before:.4g} nats a frame before, {s.after:.4g} "
            f"after, {s.other_half:.4g} with what the other half found"
            for s in self.scores
        ]
        if sum(s.other_half - s.before for s in self.scores) < 0:
            said.append(
                "what one half found predicts the other worse than the pen file: do not take it"
            )
        said += [self._delay_text()] if OFFSET in self._told() else []
        apart = [n for n in self.found if n.halves_apart > APART]
        if apart:
            said.append(
                f"halves disagree on {', '.join(n.name for n in apart)}: deviations are too small"
            )
        not_taken = self.whole.told & ~self.fit.told
        for i in np.flatnonzero(not_taken):
            number, q = self.numbers[i], self.numbers[i].quantity
            said.append(
                f"{number.name}: left as it was, what one half found does not help the other "
                f"({q.factor * self.whole.values[i]:+.3g} ± {q.factor * self.whole.std[i]:.2g} "
                f"{q.unit} with all free)"
            )
        untold = [n.name for n, told in zip(self.numbers, self.whole.told, strict=True) if not told]
        if untold:
            said.append(
                f"{', '.join(untold)}: frames do not tell, left as it was; expected a pen that "
                "moves and turns as in use"
            )
        own = [q.name for q in self._told() if q in self.fixed and q is not OFFSET]
        if own:
            said.append(f"{', '.join(own)}: the recording's own, no key of the pen file")
        return said

    def _told(self) -> list[MountingQuantity]:
        pairs = zip(self.numbers, self.fit.told, strict=True)
        return list(dict.fromkeys(n.quantity for n, told in pairs if told))

    def _delay_text(self) -> str:
        number = next(n for n in self.found if n.name == OFFSET.name)
        if OFFSET in self.fixed:
            return (
                f"the camera's stamps are {-number.value:.3g} ± {number.std:.2g} ms late against "
                "the inertial sensors': take that from them, no key of the pen file does"
            )
        delay_ms = OFFSET.factor * self.delay_s - number.value
        return f"the camera's delay is {delay_ms:.4g} ± {number.std:.2g} ms"

    def to_toml(self) -> str:
        """Return the pen file's text with the numbers, and a note on where they are from.

        Raises
        ------
        InputError
            If the pen did not come from a file, or its numbers cannot be replaced.
        """
        text = self._of_file()
        note = [f"a camera's frames set these numbers (pen-mhe {version()}):", f"  {self.command}"]
        note += [f"  {n.name}: {n.value:+.4g} ± {n.std:.2g} {n.unit}" for n in self.found]
        return text.replaced(self.values, self.pen, note)

    def __repr__(self) -> str:
        return "\n\n".join([self.table.to_string(float_format="{:.4g}".format), *self.sentences()])
