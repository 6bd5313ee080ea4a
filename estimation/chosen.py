"""Machine code where a model can be compiled, CasADi's virtual machine where not."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from functools import cache
from typing import TypeVar

from estimation import native

MachineT = TypeVar("MachineT")
PythonT = TypeVar("PythonT")


def chosen(
    compiled: Callable[[], MachineT], interpreted: Callable[[], PythonT]
) -> MachineT | PythonT:
    """Return a loop as machine code where there is a compiler and the model can be compiled.

    A model that calls what CasADi cannot write as C (an integrator of SUNDIALS, a function in
    Python) runs interpreted, and a warning says so once.
    """
    if native.compiler() is None:
        return interpreted()
    try:
        return compiled()
    except native.NotCompilableError as error:
        told = re.search(r"#error (.*)", str(error))
        _warn_once(told[1] if told else str(error).splitlines()[0])
        return interpreted()


@cache
def _warn_once(reason: str) -> None:
    warnings.warn(
        f"the model's functions cannot be compiled and are interpreted, which is slower: {reason}",
        RuntimeWarning,
        stacklevel=4,
    )
