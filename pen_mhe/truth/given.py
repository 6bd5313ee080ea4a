"""A truth as somebody gives it: where it is, and what is known of its clock and frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from estimation.truth import Truth
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.truth.align import check_said
from recordings.asked import Asked, ColumnsAsked
from recordings.truths.of_recording import track_of_truth
from recordings.truths.read import read_truth
from recordings.truths.track import TruthTrack

TruthSource = str | Path | Truth | TruthTrack
"""Path of a file of any format that is read, true states by their names, or a track."""


@dataclass(frozen=True, eq=False)
class GivenTruth:
    """A truth that an estimate is compared with, and which the estimator never sees.

    Parameters
    ----------
    source : where it is
    offset_s : what is added to its times; None finds it
    frame : one of `pen_mhe.truth.align.FRAMES`; None finds it
    columns, units : of its file, see `recordings.truths.asked.QUANTITIES`

    Raises
    ------
    InputError
        If the frame is none of these, the offset is no number, or columns are given for no file.
    """

    source: TruthSource
    offset_s: float | None = None
    frame: str | None = None
    columns: ColumnsAsked | None = None
    units: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        check_said(self.offset_s, self.frame)
        if isinstance(self.source, Truth | TruthTrack) and (self.columns or self.units):
            what = "columns" if self.columns else "units"
            raise InputError(f"{what} are given for a truth that is no file, expected none")

    @classmethod
    def of(cls, source: TruthSource | None, **said: Any) -> GivenTruth | None:
        """Return it as it is given by its parts; None where there is none.

        Raises
        ------
        InputError
            If something is said of a truth that is not there, or of no such frame.
        """
        if source is not None:
            return cls(source, **said)
        for name, value in said.items():
            if value not in (None, {}):
                what = name.removesuffix("_s")
                raise InputError(f"{what} of the truth given without a truth, expected both")
        return None

    def track(self, pen: PenConfig, origin_s: float) -> TruthTrack:
        """Return the track; reads the file.

        Parameters
        ----------
        origin_s : of the recording's times, see `recordings.truths.read.read_truth`

        Raises
        ------
        InputError
            If it cannot be read, or holds nothing of a pen's motion.
        """
        if isinstance(self.source, TruthTrack):
            return self.source
        if isinstance(self.source, Truth):
            return track_of_truth(self.source, "as given")
        asked = Asked.of(self.units, self.columns)
        return read_truth(self.source, pen, origin_s=origin_s, asked=asked)
