"""IPOPT's own options, tried before a window is built: a misspelt one is no traceback of CasADi."""

from __future__ import annotations

import contextlib
import io
import itertools
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from models.errors import InputError

Option = bool | int | float | str
"""Of IPOPT; yes and no may be Booleans."""

QUIET: Mapping[str, Option] = MappingProxyType({"print_level": 0, "sb": "yes"})
LIST = "https://coin-or.github.io/Ipopt/OPTIONS.html"
KINDS: Mapping[str, str] = MappingProxyType(
    {"is_int()": "a whole number", "is_double()": "a number", "is_string()": "a text"}
)
"""What CasADi asks of a value → what it should be."""
NOT_TAKEN = ("Invalid_Option", "Internal_Error", "Unrecoverable_Exception")
"""Return statuses of a problem that has nothing wrong but its options."""


def checked_options(given: object) -> dict[str, Option]:
    """Return IPOPT's options as it takes them.

    Raises
    ------
    InputError
        If it does not know one, or does not take its value.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"ipopt is {given!r}, expected IPOPT's options by name")
    options = {name: _value(name, value) for name, value in given.items()}
    for name, value in options.items():
        problem = _tried({name: value})
        if problem is not None:
            raise InputError(f"IPOPT option {name}{problem}")
    if len(options) > 1 and _tried(options) is not None:
        named = ", ".join(f"{name}={value}" for name, value in options.items())
        raise InputError(f"IPOPT options {named} do not go together, expected others")
    return options


def _value(name: object, value: object) -> Option:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(name, str) or not isinstance(value, int | float | str):
        raise InputError(f"IPOPT option {name} is {value!r}, expected a number or a text")
    return value


def _tried(options: Mapping[str, Option]) -> str | None:
    """Return what is wrong with options behind their name; None where nothing is."""
    x, printed, value = ca.SX.sym("x"), io.StringIO(), next(iter(options.values()))
    prefixed: dict[str, Any] = {f"ipopt.{k}": v for k, v in {**QUIET, **options}.items()}
    try:
        with contextlib.redirect_stdout(printed):
            problem = {"x": x, "f": x**2}
            solver = ca.nlpsol("trial", "ipopt", problem, {"print_time": False, **prefixed})
            solver(x0=1.0)
    except RuntimeError as error:
        if "No such IPOPT option" in str(error):
            return f" is unknown, expected one of {LIST}"
        kinds = [kind for check, kind in KINDS.items() if check in str(error)]
        return f" is {value!r}, expected {kinds[0] if kinds else _allowed(printed.getvalue())}"
    if solver.stats()["return_status"] in NOT_TAKEN:
        return f" is {value!r}, which this IPOPT does not have, expected another"
    return None


def _allowed(printed: str) -> str:
    """Return what IPOPT's own page of an option, as it prints it, allows."""
    lines = [line.strip() for line in printed.splitlines()]
    if "Valid Settings:" in lines:
        behind = lines[lines.index("Valid Settings:") + 1 :]
        settings = itertools.takewhile(lambda line: not line.startswith("Default:"), behind)
        return f"one of {', '.join(line.split()[0] for line in settings if line)}"
    ranges = [line for line in lines if "<" in line and "(" in line]
    return ranges[-1] if ranges else f"what {LIST} says of it"
