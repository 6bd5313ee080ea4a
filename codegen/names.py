"""Names for C, made of those of a model."""

from __future__ import annotations

import re
from collections.abc import Iterable

from models.errors import InputError

IDENTIFIER = re.compile(r"[a-z][a-z0-9_]*")


def check_prefix(prefix: str) -> None:
    """Raise `InputError` unless names of C and of files can begin with it."""
    if not IDENTIFIER.fullmatch(prefix):
        raise InputError(
            f"prefix {prefix!r}, expected small letters, digits and underscores, a letter first"
        )


def macros(names: Iterable[str]) -> list[str]:
    """Return distinct names in capitals: ``tip_x_m`` → ``TIP_X_M``, ``x-1`` → ``X_1``."""
    found: list[str] = []
    for name in names:
        plain = re.sub(r"[^A-Z0-9_]", "_", name.upper()) or "_"
        number, unique = 2, plain
        while unique in found:
            unique, number = f"{plain}_{number}", number + 1
        found.append(unique)
    return found
