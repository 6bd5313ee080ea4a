"""Numbers as C writes them, in the precision of an export."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)(?![\w.])")
"""A number with a point or an exponent, and without a suffix: C takes it for a double."""

CALL = re.compile(r"\b([a-z][a-z0-9]*)\(")

SINGLE = frozenset(
    (
        *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil"),
        *("copysign", "cos", "cosh", "erf", "erfc", "exp", "expm1", "fabs", "floor"),
        *("fma", "fmax", "fmin", "fmod", "hypot", "log", "log10", "log1p", "log2"),
        *("pow", "remainder", "round", "sin", "sinh", "sqrt", "tan", "tanh", "trunc"),
    )
)
"""Functions of <math.h> that have a sibling in single precision, with an f at its name's end."""


@dataclass(frozen=True)
class Precision:
    """A type for real numbers in C.

    Parameters
    ----------
    c_type : ``double`` or ``float``
    dtype : the same in NumPy
    suffix : of a literal
    """

    c_type: str
    dtype: type[np.floating]
    suffix: str

    def number(self, value: float) -> str:
        """Return a number as a literal; what is too large for the type is infinite."""
        if math.isnan(value):
            return "NAN"
        if abs(value) > float(np.finfo(self.dtype).max):
            return "INFINITY" if value > 0 else "-INFINITY"
        return f"{value!r}{self.suffix}"

    def literals(self, source: str) -> str:
        """Return generated C whose literals are of the type."""
        return LITERAL.sub(rf"\1{self.suffix}", source) if self.suffix else source

    def functions(self, sources: Iterable[str]) -> list[str]:
        """Return macros that take the functions of <math.h> which sources call to the type."""
        if not self.suffix:
            return []
        called = {name for source in sources for name in CALL.findall(source)}
        return [f"#define {name} {name}{self.suffix}" for name in sorted(called & SINGLE)]


PRECISIONS: Mapping[str, Precision] = MappingProxyType(
    {
        "double": Precision("double", np.float64, ""),
        "float": Precision("float", np.float32, "f"),
    }
)
"""Name → precision; <tgmath.h> would choose by itself, but not every small C library's works."""
