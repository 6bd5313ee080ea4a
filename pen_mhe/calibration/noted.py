"""Calibrated numbers as a table, and as notes of a pen file: what all calibrations share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from models.pen_config import PenConfig
from models.version import version
from pen_mhe.calibration.sensor_result import CalibratedNumber
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText

if TYPE_CHECKING:
    import pandas as pd


def number_table(numbers: Sequence[CalibratedNumber]) -> pd.DataFrame:
    """Return a row per number: value, deviation, unit."""
    import pandas as pd

    index = pd.MultiIndex.from_tuples(
        [(n.sensor, n.quantity) for n in numbers], names=["sensor", "quantity"]
    )
    rows = [(n.value, n.std, n.unit) for n in numbers]
    return pd.DataFrame(rows, index=index, columns=["value", "std", "unit"])


def with_numbers(
    text: PenText,
    numbers: Sequence[CalibratedNumber],
    values: Mapping[Parameter, Any],
    pen: PenConfig,
    *,
    title: str,
    command: str,
) -> str:
    """Return a pen file's text with values (SI), and a note on what they are from.

    An older note keeps what is not found anew.

    Parameters
    ----------
    pen : what the new text must mean
    title, command : of the note: what set them, and what does the same on a terminal

    Raises
    ------
    InputError
        If the file's numbers cannot be replaced.
    """
    anew = tuple(f"#   {n.sensor} {n.quantity}: " for n in numbers)
    kept = [line for line in text.lines if not line.startswith(anew)]
    note = [f"{title} (pen-mhe {version()}):", f"  {command}"]
    note += [
        f"  {n.sensor} {n.quantity}: {n.value:.6g} ± {n.std:.2g} {n.unit}".rstrip() for n in numbers
    ]
    return PenText("\n".join(kept), text.where).replaced(values, pen, note)
