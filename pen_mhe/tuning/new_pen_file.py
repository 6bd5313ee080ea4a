"""A result that is a pen file with other numbers: what tuning and calibrations share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING

from estimation.output_file import write_whole
from models.errors import InputError
from pen_mhe.tuning.pen_text import PenText


class NewPenFile(ABC):
    """Writes a pen file anew; ``text`` is the one that the numbers were for."""

    if TYPE_CHECKING:
        text: PenText | None

    @abstractmethod
    def to_toml(self) -> str:
        """Return the pen file's text with the new numbers, and a note on where they are from.

        Raises
        ------
        InputError
            If the pen did not come from a file, or the file's numbers cannot be replaced.
        """

    def write(self, path: str | Path) -> None:
        """Write the text of `to_toml` beside the file's place, and put it there whole.

        Raises
        ------
        InputError
            As `to_toml`, or if the file cannot be written.
        """
        write_whole(path, self.to_toml())

    def _of_file(self) -> PenText:
        """Return the text to write anew; `InputError` where the pen did not come from a file."""
        if self.text is None:
            raise InputError("this pen was given as data, expected a pen file to write anew")
        return self.text
