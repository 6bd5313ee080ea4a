"""Whether the rooms that Python finds are ours.

They are packages with plain names: a file models.py beside a script comes before ours. This
module imports no other room: it may not be ours.
"""

from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from pathlib import Path

HOUSE = Path(__file__).resolve().parent.parent
"""The folder that the rooms stand in: a checkout, or where packages are installed."""


def check_rooms(door: str) -> None:
    """Raise `ImportError` where something else comes before a room on Python's path.

    Parameters
    ----------
    door : ``__init__.py`` of the front door; its stub names the rooms that it imports
    """
    stub = Path(door).with_suffix(".pyi").read_text("utf-8")
    for room in sorted(set(re.findall(r"^from (\w+)", stub, re.MULTILINE))):
        found = _found(room)
        if found is not None and found.resolve().parent != HOUSE / room:
            whole = found.parent if found.name == "__init__.py" else found
            raise ImportError(
                f"pen_mhe needs its own package {room} in {HOUSE}, but Python finds {whole} "
                f"first, expected no other {room} on the path: rename that one, "
                "or work in another folder",
                name=room,
                path=str(found),
            )


def _found(room: str) -> Path | None:
    """Return the file that an import of a room runs or has run, None where there is none."""
    loaded = sys.modules.get(room)
    spec = find_spec(room) if loaded is None else None
    file = spec.origin if spec else getattr(loaded, "__file__", None)
    return Path(file) if file else None
