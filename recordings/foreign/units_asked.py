"""Units as an option or a pen file says them: ``mg``, and counts: ``g/16384``, ``0.061*mg``."""

from __future__ import annotations

import math
import re

from models.errors import InputError
from models.names import did_you_mean
from recordings.foreign.column_names import KIND_OF_SI, unit_of_kind
from recordings.foreign.header_units import KNOWN_UNITS, Unit, unit_of

_SCALED = re.compile(r"(?:(?P<times>[\d.eE+-]+)\*)?(?P<unit>[^*]+?)(?:/(?P<per>[\d.eE+-]+))?")


def unit_asked(text: str, si: str, where: str) -> Unit:
    """Return the unit that a text says.

    Parameters
    ----------
    si : unit of the quantity, in which it must be
    where : file, and the text itself

    Raises
    ------
    InputError
        If it is none of that quantity.
    """
    found = _SCALED.fullmatch(text.strip())
    known = [name for name, unit in KNOWN_UNITS.items() if unit.si == si]
    name = "" if found is None else found["unit"].strip()
    unit = unit_of_kind(KIND_OF_SI.get(si, ""), KNOWN_UNITS.get(name) or unit_of(name))
    if found is None or unit is None or unit.si != si:
        raise InputError(
            f"{where} is unknown, expected {' or '.join(known)}, or counts like {known[-1]}/16384"
            f"{did_you_mean(text, known)}"
        )
    try:
        factor = float(found["times"] or 1) / float(found["per"] or 1)
    except (ValueError, ZeroDivisionError):
        factor = math.nan
    if not (math.isfinite(factor) and factor > 0):
        raise InputError(f"{where}, expected a positive number beside the unit")
    return unit if factor == 1 else Unit(text.strip(), si, unit.factor * factor)
