"""Lines that become rows of cells: the forms that programs print, a file each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import BinaryIO

from recordings.formats.bracketed_vectors import bracketed_form
from recordings.formats.ended_lines import ended_form
from recordings.formats.i2cdev_lines import i2cdev_form
from recordings.formats.influx_lines import influx_form
from recordings.formats.printed_blocks import block_form
from recordings.formats.sentences import sentence_form
from recordings.formats.serial_lines import LineForm, labelled_form
from recordings.formats.start_and_rate import start_and_rate_form
from recordings.formats.teleplot_lines import teleplot_form
from recordings.formats.unpacked import spooled
from recordings.formats.yaml_records import yaml_form

LINE_FORMS: tuple[Callable[[Sequence[str]], LineForm | None], ...] = (
    start_and_rate_form,
    teleplot_form,
    yaml_form,
    influx_form,
    block_form,
    i2cdev_form,
    bracketed_form,
    sentence_form,
    labelled_form,
    ended_form,
)
"""Each returns its form of lines, the first of a text, or None; the first form counts."""


def line_form(lines: Sequence[str]) -> LineForm | None:
    """Return how lines, the first of a text, are to be rewritten; None where they are rows."""
    return next((form for find in LINE_FORMS if (form := find(lines)) is not None), None)


def rewritten(file: BinaryIO, form: LineForm) -> BinaryIO:
    """Return the rest of a text in a form of lines, at its beginning."""
    found = spooled()
    for row in form.rows(_texts(file, form)):
        found.write(row.encode() + b"\n")
    found.seek(0)
    return found


def _texts(file: BinaryIO, form: LineForm) -> Iterator[str]:
    for line in file:
        text = line.decode("utf-8", "replace")
        is_cut = form.ends_lines and not text.endswith(("\r", "\n"))
        yield f"{text} (cut off)" if is_cut else text.rstrip("\r\n")
