"""What a tuning found: numbers before and after, their worth, and how well they are determined."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from models.pen_config import PenConfig
from models.version import version
from pen_mhe.tuning.new_pen_file import NewPenFile
from pen_mhe.tuning.objectives import OBJECTIVES
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText
from pen_mhe.tuning.score import Score

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class TunedNumber:
    """One number of a pen file, in the file's unit.

    Parameters
    ----------
    key : with its table, as the file spells it
    before, after : its values
    low, high : range within which, alone, it loses next to nothing; 0 and inf where no end of
        it was found
    """

    key: str
    before: float
    after: float
    low: float
    high: float

    @property
    def is_determined(self) -> bool:
        """Whether both ends of the range were found."""
        return self.low > 0 and math.isfinite(self.high)

    @property
    def range_text(self) -> str:
        """The range in words."""
        if self.is_determined:
            return f"{self.low:.3g} to {self.high:.3g}"
        if self.low > 0:
            return f"above {self.low:.3g}"
        return f"below {self.high:.3g}" if math.isfinite(self.high) else "anything"


@dataclass(frozen=True, eq=False, repr=False)
class Tuning(NewPenFile):
    """What `tune` returns.

    Parameters
    ----------
    pen : with the numbers that were found
    objective, sensors, fit, score : that were asked for
    numbers : that were tuned
    fitted : the objective's scores on the part that was fitted, before and after
    scores : objective → scores before and after on the other part, all that it has data for
    evaluations : how many times the filter's parameters were changed
    """

    pen: PenConfig
    objective: str
    sensors: tuple[str, ...]
    fit: str
    score: str
    recording_name: str
    pen_name: str
    numbers: tuple[TunedNumber, ...]
    fitted: tuple[Score, Score]
    scores: Mapping[str, tuple[Score, Score]]
    evaluations: int
    values: Mapping[Parameter, float]
    text: PenText | None

    @property
    def command(self) -> str:
        """What does the same on a terminal."""
        words = [
            "pen-mhe",
            "tune",
            self.recording_name,
            *("--pen", self.pen_name),
            *("--sensors", ",".join(self.sensors)),
            *("--objective", self.objective),
            *("--parameters", ",".join(parameter.key for parameter in self.values)),
            *("--fit", self.fit),
            *("--score", self.score),
        ]
        return shlex.join(words)

    @property
    def table(self) -> pd.DataFrame:
        """A row per number: before, after, and its range."""
        import pandas as pd

        rows = [(n.before, n.after, n.low, n.high) for n in self.numbers]
        index = pd.Index([n.key for n in self.numbers], name="key")
        return pd.DataFrame(rows, index=index, columns=["before", "after", "low", "high"])

    @property
    def worth(self) -> pd.DataFrame:
        """A row per figure on the part that is scored: before and after."""
        import pandas as pd

        rows, index = [], []
        for name, (before, after) in self.scores.items():
            for figure, value in before.figures.items():
                index.append((name, figure))
                rows.append((value, after.figures[figure]))
        return pd.DataFrame(
            rows,
            index=pd.MultiIndex.from_tuples(index, names=["objective", "figure"]),
            columns=["before", "after"],
        )

    def sentences(self) -> list[str]:
        """Return what a person should know of the result."""
        row = OBJECTIVES[self.objective]
        before, after = self.fitted
        said = [
            f"{self.objective} on {self.fit}: {before.value:.6g} → {after.value:.6g} {row.unit} "
            f"({self.evaluations} evaluations)"
        ]
        if before.value - after.value <= after.loss:
            said.append(f"the old numbers are as good: they lose less than {row.loss_text}")
        said += [
            f"{number.key} is not determined: {number.range_text} loses less than {row.loss_text}"
            for number in self.numbers
            if not number.is_determined
        ]
        if self.objective in self.scores:
            was, now = self.scores[self.objective]
            if now.value > was.value:
                said.append(
                    f"on {self.score} the new numbers are worse than the old ones "
                    f"({was.value:.6g} → {now.value:.6g} {row.unit}): do not take them"
                )
        unsuited = [p.key for p in self.values if not row.proposes(p)]
        if unsuited:
            said.append(
                f"{', '.join(unsuited)}: {self.objective} is no good judge of it; "
                "compare the other scores"
            )
        return said

    def to_toml(self) -> str:
        """Return the pen file's text with the new numbers, and a note which objective set them.

        Raises
        ------
        InputError
            If the pen did not come from a file, or the file's numbers cannot be replaced.
        """
        text = self._of_file()
        note = [f"{self.objective} set these numbers (pen-mhe {version()}):", f"  {self.command}"]
        if self.objective in self.scores:
            was, now = self.scores[self.objective]
            unit = OBJECTIVES[self.objective].unit
            note.append(f"  {self.score}: {was.value:.6g} before, {now.value:.6g} {unit} after")
        return text.replaced(self.values, self.pen, note)

    def __repr__(self) -> str:
        shown = "{:.4g}".format
        return "\n\n".join(
            [
                self.table.to_string(float_format=shown),
                self.worth.to_string(float_format="{:.6g}".format),
                *self.sentences(),
            ]
        )
