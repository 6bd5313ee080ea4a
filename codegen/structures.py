"""An estimator's structures as static C: what `estimation.engine` hands over through addresses."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codegen.number_format import Precision
from estimation.layout import Layout
from estimation.loop import NO_FUNCTION, Pointers

LINE = 96


@dataclass
class StaticC:
    """C text that is collected while a tree of values is walked.

    Parameters
    ----------
    precision : of real numbers
    prefix : of the generated functions' names
    functions : their names → numbers of arguments and results
    types : declarations of structures, inner ones first
    arrays : static arrays that the structures point to
    """

    precision: Precision
    prefix: str
    functions: Mapping[str, tuple[int, int]]
    types: list[str] = field(default_factory=list)
    arrays: list[str] = field(default_factory=list)

    def structure(self, kind: str, values: Mapping[str, Any], path: str) -> str:
        """Declare a structure of given values and return its initialiser; see `Loop.fields`.

        Parameters
        ----------
        kind : name of its type
        path : prefix of the names of its arrays
        """
        members = {name: self._member(name, value, path) for name, value in values.items()}
        lines = [f"    {c_type} {name};" for name, (c_type, _) in members.items()]
        self.types.append("\n".join(["typedef struct {", *lines, f"}} {kind};"]))
        return braces([f".{name} = {text}" for name, (_, text) in members.items()])

    def _member(self, name: str, value: Any, path: str) -> tuple[str, str]:
        """Return a member's C type and initialiser."""
        match value:
            case None:
                return "real *", "0"
            case str():
                return "Function", self._function(value)
            case bool() | int() | np.integer():
                return "integer", str(int(value))
            case float():
                return "real", self.precision.number(float(value))
            case ctypes.c_void_p():
                if value.value:
                    raise ValueError(f"{name} is an address of this process, expected none")
                return "generated", "0"
            case Pointers():
                c_type = "const real *" if value.constant else "real *"
                self.arrays.append(f"static {c_type}{path}_{name}[{value.size}];")
                return f"{c_type}*", f"{path}_{name}"
            case np.ndarray():
                return self._array(value, f"{path}_{name}")
            case Layout():
                offsets = {block: part.start for block, part in value.slices.items()}
                return value.name, self.structure(value.name, {**offsets, "size": value.size}, path)
            case Mapping():
                kind = name.capitalize()
                return kind, self.structure(kind, value, f"{path}_{name}")
        raise TypeError(f"{name}: {type(value).__name__} has no C form")

    def _function(self, name: str) -> str:
        """Return the initialiser of a generated function; its numbers stand in its own code."""
        if name == NO_FUNCTION:
            return "{0, 0, 0, 0}"
        n_arguments, n_results = self.functions[name]
        return f"{{{self.prefix}_{name}, 0, {n_arguments}, {n_results}}}"

    def _array(self, value: NDArray[Any], name: str) -> tuple[str, str]:
        """Return the pointer to an array: workspace where it is all zeros, else a table."""
        c_type = {"f": "real", "i": "integer", "b": "unsigned char"}[value.dtype.kind]
        if not value.any():
            self.arrays.append(f"static {c_type} {name}[{max(value.size, 1)}];")
            return f"{c_type} *", name
        numbers = [self._number(x) for x in value.ravel()]
        self.arrays.append(
            f"static const {c_type} {name}[{value.size}] = {braces(numbers)};",
        )
        return f"const {c_type} *", name

    def _number(self, value: Any) -> str:
        if isinstance(value, np.floating):
            return self.precision.number(float(value))
        return str(int(value))


def braces(items: list[str]) -> str:
    """Return items between braces, in lines of at most `LINE` characters or one item each."""
    lines, line = [], "   "
    for item in items:
        if len(line) > 3 and len(line) + len(item) + 2 > LINE:
            lines.append(line)
            line = "   "
        line += f" {item},"
    return "\n".join(["{", *lines, line, "}"])
