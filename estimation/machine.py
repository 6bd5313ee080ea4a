"""A model and its loop as structures of C whose functions are compiled side by side.

What a model's numbers are stands in the structures, and what its formulas are in generated
functions (`estimation.lifted`); the Kalman stage is compiled for models of one size, the loop for
all. So a second model of the same shape compiles nothing.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from ctypes import addressof, c_char
from typing import Any

import casadi as ca
import numpy as np

from estimation.layout import ArgumentRoom, KernelAddress, ResultRoom, declaration
from estimation.lifted import lifted
from estimation.loop import GENERATED, Pointers, kernel_sources, stage_sizes
from estimation.native import STRICT, VECTORS, CSource, shared_libraries
from estimation.stage_limits import stage_limits
from models.arrays import Array
from models.state_space import StateSpaceModel

DOUBLES = ctypes.POINTER(ctypes.c_double)
INTEGERS = ctypes.POINTER(ctypes.c_longlong)
BYTES = ctypes.POINTER(ctypes.c_ubyte)
ARRAYS: Mapping[str, tuple[type, type]] = {
    "f": (np.float64, DOUBLES),
    "i": (np.int64, INTEGERS),
    "b": (np.uint8, BYTES),
}
"""Kind of a NumPy array → its type and the pointer to it."""
KERNEL = ("predict", "update", "sweep")
"""Members of C's structure Model that hold the compiled stage."""


class Function(ctypes.Structure):
    """A generated function for C; see `estimation.loop.GENERATED`."""

    _fields_ = (
        ("evaluate", ctypes.c_void_p),
        ("constants", DOUBLES),
        ("n_arguments", ctypes.c_longlong),
        ("n_results", ctypes.c_longlong),
    )


class Machine:
    """Structures for C, and all that they point to, alive as long as this is."""

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def structure(self, kind: str, values: Mapping[str, Any]) -> ctypes.Structure:
        """Return a structure of given values, their kinds as of `estimation.loop.Loop`.

        A generated function has no address yet; see `load`.

        Parameters
        ----------
        kind : name of its type
        """
        members = {name: self._value(name, value) for name, value in values.items()}
        fields = [(member, type(value)) for member, value in members.items()]
        made = type(kind, (ctypes.Structure,), {"_fields_": fields})(*members.values())
        self._kept.append(made)
        return made

    def load(
        self,
        functions: Sequence[ca.Function],
        places: Sequence[ctypes.Structure],
        others: Sequence[CSource],
    ) -> list[ctypes.CDLL]:
        """Compile what is not in the cache, all at once, and say to C where its functions are.

        Parameters
        ----------
        functions : generated ones, a library each: a model with other sensors needs few others
        places : structures with members of the functions' names, C's structure Model first
        others : C that is compiled beside, the Kalman stage first

        Returns
        -------
        The libraries of `others`.
        """
        lifts = [lifted(function) for function in functions]
        sources = [CSource(lift.code, is_of_model=True) for lift in lifts]
        paths = shared_libraries([*sources, *others])
        libraries = [ctypes.CDLL(str(path)) for path in paths]
        self._kept += libraries
        for library, function, lift in zip(libraries, functions, lifts, strict=False):
            entry = ctypes.cast(library[function.name()], ctypes.c_void_p)
            constants = self._value("constants", lift.constants)
            made = Function(entry, constants, function.n_in(), function.n_out())
            for place in places:
                if isinstance(getattr(place, function.name(), None), Function):
                    setattr(place, function.name(), made)
        stage, *rest = libraries[len(functions) :]
        for name in KERNEL:
            setattr(places[0], name, ctypes.cast(stage[f"kernel_{name}"], ctypes.c_void_p).value)
        return rest

    def _value(self, name: str, value: Any) -> Any:
        """Return a value for C."""
        match value:
            case None:
                return DOUBLES()
            case str():
                return Function()
            case bool() | int() | np.integer():
                return ctypes.c_longlong(int(value))
            case float():
                return ctypes.c_double(value)
            case ctypes.c_void_p() | ctypes.Structure():
                return value
            case Pointers():
                room = (ctypes.c_void_p * value.size)()
                self._kept.append(room)
                kind = ArgumentRoom if value.constant else ResultRoom
                return kind(ctypes.addressof(room))
            case np.ndarray():
                dtype, pointer = ARRAYS[value.dtype.kind]
                array = np.require(value, dtype=dtype, requirements="C")
                self._kept.append(array)
                return array.ctypes.data_as(pointer)
            case Mapping():
                return self.structure(name.capitalize(), value)
        raise TypeError(f"{name}: {type(value).__name__} has no C form")


def kernel_fields() -> dict[str, ctypes.c_void_p]:
    """Return the members of C's structure Model that hold the compiled stage, without it."""
    return {name: KernelAddress(0) for name in KERNEL}


def kernel(model: StateSpaceModel, described: type[ctypes.Structure]) -> CSource:
    """Return the C of the Kalman stage for models that are as large."""
    parts = [
        *(f"#define {name} {value}" for name, value in stage_sizes(model).items()),
        *declared(stage_limits(np.float64), [described]),
        *kernel_sources(),
    ]
    return CSource("\n".join(parts), (*STRICT, *VECTORS))


def declared(
    constants: Mapping[str, float], structures: Sequence[type[ctypes.Structure]]
) -> list[str]:
    """Return what stands in front of C that is compiled here."""
    return [
        "#define _POSIX_C_SOURCE 199309L",
        "#define PEN_MHE_HOSTED",
        "typedef double real;",
        "typedef long long integer;",
        GENERATED,
        "typedef void (*kernel)(void);",
        *(f"#define {name} {value!r}" for name, value in constants.items()),
        *(declaration(structure) for structure in structures),
    ]


def address(array: Array) -> int:
    """Return the address of a contiguous array's first number."""
    try:  # four times as fast as the array interface
        return addressof(c_char.from_buffer(array))  # type: ignore[arg-type]
    except (TypeError, ValueError):  # read-only, or empty
        return int(array.__array_interface__["data"][0])
