"""A pen file that a command writes: never the one that it reads."""

from __future__ import annotations

from pathlib import Path

from models.bundled import bundled_pens
from models.errors import InputError

SUFFIX = ".toml"


def prepare_pen_output(output: Path, pen: str) -> None:
    """Refuse an output that is no pen file, or a pen file that is read; make its folder."""
    from recordings.formats.tables import prepare_output  # tables are slow to import

    pens = (Path(pen), *bundled_pens().values())
    if output.resolve() in {pen.resolve() for pen in pens}:
        raise InputError(
            f"output {output} is the pen file that is read, or a bundled one, expected "
            "another file: compare them, then put it in place"
        )
    prepare_output(output, (SUFFIX,))
