"""Functions that a person gives: how many arguments they take, and whether they take ours."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from models.errors import InputError


def n_arguments(function: Callable[..., Any]) -> int:
    """Return how many arguments a function needs; one with a default value is its own affair."""
    if isinstance(function, ca.Function):
        return int(function.n_in())
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    parameters = _signature(function).parameters.values()
    return sum(p.kind in kinds and p.default is p.empty for p in parameters)


def check_arguments(what: str, function: object, names: tuple[str, ...]) -> None:
    """Raise `InputError` unless a function can be called with arguments of these names."""
    expected = f"expected a function of ({', '.join(names)})"
    if not callable(function):
        raise InputError(f"{what} is {function!r}, {expected}")
    if isinstance(function, ca.Function):
        if function.n_in() != len(names):
            raise InputError(f"{what} takes {function.n_in()} arguments, {expected}")
        return
    try:
        _signature(function).bind(*names)
    except TypeError:
        raise InputError(f"{what} takes {_signature(function)}, {expected}") from None


def called(what: str, function: Callable[..., Any], symbols: Sequence[ca.SX]) -> Any:
    """Return what a person's function makes of symbols.

    Parameters
    ----------
    what : it is, for messages

    Raises
    ------
    InputError
        If CasADi cannot do with symbols what it asks for. Errors of its own go through.
    """
    try:
        return function(*symbols)
    except RuntimeError as error:
        if "casadi" not in str(error):
            raise
        shapes = ", ".join(str(symbol.shape) for symbol in symbols)
        told = str(error).strip().splitlines()[-1].rpartition(": ")[2].rstrip(".")
        raise InputError(
            f"{what} is called with symbols of shapes {shapes}, and CasADi says: {told}; "
            "expected expressions of these symbols, ca.if_else where a number would choose"
        ) from error


def check_symbols(what: str, expression: ca.SX, arguments: Mapping[str, ca.SX]) -> None:
    """Raise `InputError` where an expression has symbols that are none of its arguments."""
    free = ca.Function("free", list(arguments.values()), [expression], {"allow_free": True})
    if free.has_free():
        raise InputError(
            f"{what} depends on {', '.join(free.get_free())}, "
            f"expected nothing but {', '.join(arguments)}"
        )


def _signature(function: Callable[..., Any]) -> inspect.Signature:
    try:
        return inspect.signature(function)
    except ValueError:  # some that are written in C do not say
        return inspect.signature(lambda *any_number: None)
