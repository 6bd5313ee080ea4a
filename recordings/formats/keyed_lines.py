"""Lines that name every number: ``ax:0.12,ay:-0.03``, as Arduino's serial plotter takes them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import BinaryIO

from recordings.formats.unpacked import spooled

KEY = re.compile(r"([A-Za-z_][\w .\[\]/]{0,40}?)\s*[:=]\s*(?=[+-]?[\d.])")
LEAST_ALIKE = 0.5
"""Part of the lines that name the same, from which they are rows."""
LEAST_KEYS = 2


def keys_of(lines: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the numbers in lines; nothing where most lines do not name them."""
    found = [tuple(key.strip() for key in KEY.findall(line)) for line in lines]
    named = [keys for keys in found if len(keys) >= LEAST_KEYS]
    if not named:
        return ()
    most = max(set(named), key=named.count)
    return most if named.count(most) >= LEAST_ALIKE * len(lines) else ()


def bare(line: str) -> str:
    """Return a line without the names of its numbers."""
    return KEY.sub("", line)


def without_keys(file: BinaryIO) -> BinaryIO:
    """Return the rest of a text without the names of its numbers, at its beginning."""
    found = spooled()
    for line in file:
        found.write(bare(line.decode("utf-8", "replace")).encode())
    found.seek(0)
    return found
