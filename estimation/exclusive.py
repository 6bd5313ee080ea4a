"""Estimators that threads may share, and that pickle: each has a workspace of its own.

Two threads in one workspace would end in numbers of nobody's, or in the end of the process. So a
thread that comes while another is in a step waits for it. A workspace does not pickle; model and
settings do, and a copy is built of them anew.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

ExclusiveT = TypeVar("ExclusiveT", bound="Exclusive")
ParametersT = ParamSpec("ParametersT")
ResultT = TypeVar("ResultT")


class Exclusive:
    """An estimator in which one thread is at a time.

    Parameters
    ----------
    parts, options : what it is built of again. One whose first part is another takes the same turns
        as that, which it drives
    """

    def __init__(self, *parts: Any, **options: Any) -> None:
        self._again = partial(type(self), *parts, **options)
        inner = parts[0]
        self._turn: Any = inner._turn if isinstance(inner, Exclusive) else threading.RLock()

    def __reduce__(self) -> tuple[Callable[[], Any], tuple[()]]:
        return self._again, ()


def in_turn(
    method: Callable[Concatenate[ExclusiveT, ParametersT], ResultT],
) -> Callable[Concatenate[ExclusiveT, ParametersT], ResultT]:
    """Make a method wait until no other thread is in one of the same estimator."""

    @wraps(method)
    def waiting(
        self: ExclusiveT, /, *args: ParametersT.args, **kwargs: ParametersT.kwargs
    ) -> ResultT:
        with self._turn:
            return method(self, *args, **kwargs)

    return waiting
