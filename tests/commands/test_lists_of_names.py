"""Lists of names on the command line: with commas, and of names that hold one."""

from __future__ import annotations

import pytest

from commands.options import names
from models.errors import InputError


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (None, None),
        ("accel, gyro", ("accel", "gyro")),
        ('rest,"free pen, handwriting"', ("rest", "free pen, handwriting")),
        ('rest, "free pen, handwriting"', ("rest", "free pen, handwriting")),
        (",rest,", ("rest",)),
    ],
)
def test_names(text: str | None, expected: tuple[str, ...] | None) -> None:
    assert names(text) == expected


@pytest.mark.parametrize("text", ["", ",", '""', " , "])
def test_a_list_without_a_name(text: str) -> None:
    with pytest.raises(InputError, match="has no name in it, expected"):
        names(text)
