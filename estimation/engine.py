"""The loops of estimators in compiled C, called through addresses.

An estimator's state is one flat array (a `Layout`), and so is what a step says. An
`Engine` makes one from the other; where there is no C compiler, the estimator brings an
engine in Python around the same symbolic stages.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from estimation.layout import declaration
from estimation.loop import GENERATED, engine_sources, loop_constants, model_fields
from estimation.loop import Loop as Loop  # mhe takes it from here
from estimation.native import STRICT, function_libraries, shared_libraries
from estimation.result import checked_input, result_layout
from models.arrays import Array
from models.state_space import StateSpaceModel

DOUBLES = ctypes.POINTER(ctypes.c_double)
INTEGERS = ctypes.POINTER(ctypes.c_longlong)
BYTES = ctypes.POINTER(ctypes.c_ubyte)
NATIVE = np.dtype(np.float64)


class Model(ctypes.Structure):
    """A state-space model for C: sizes, tables, and its generated stage."""

    _fields_ = (
        *((name, ctypes.c_longlong) for name in ("n_x", "n_w", "n_y", "n_r", "n_sensors")),
        ("saturation", DOUBLES),
        ("reach", DOUBLES),
        ("regularity_limit", ctypes.c_double),
        ("row_needs", BYTES),
        ("measured_rows", BYTES),
        ("first_row", INTEGERS),
        ("predict", ctypes.c_void_p),
        ("update", ctypes.c_void_p),
        ("retract", ctypes.c_void_p),
        ("regularity", ctypes.c_void_p),
        ("derived", ctypes.c_void_p),
    )


class CompiledEngine:
    """A loop as machine code, with a workspace of its own: one per thread."""

    def __init__(self, model: StateSpaceModel, loop: Loop) -> None:
        self.memory, self.result = loop.memory, result_layout(model)
        self._n_y, self._shape, self._given_shape = model.n_y, (model.n_y,), (loop.memory.size,)
        self._kept: list[Any] = []
        addresses = self._load(loop.functions)
        values: dict[str, Any] = {
            "model": self._model(model, addresses),
            "memory": loop.memory.offsets(),
            "result": self.result.offsets(),
        }
        for name, value in loop.fields.items():
            values[name] = self._c_value(name, value, addresses)
        structure = _structure(loop.entry, values)
        nested = [type(value) for value in values.values() if isinstance(value, ctypes.Structure)]
        library = ctypes.CDLL(str(_loop_library(loop, [*nested, type(structure)])))
        self._kept += [structure, library]
        self._self = ctypes.addressof(structure)
        address = ctypes.c_void_p
        self._step = library[f"{loop.entry}_step"]
        self._step.argtypes = [address, address, address, ctypes.c_double, address, address]
        self._step.restype = None
        self._batch = library[f"{loop.entry}_batch"]
        self._batch.argtypes = [address, address, address, ctypes.c_longlong, *[address] * 3]
        self._library = library

    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        if not (
            y.dtype is NATIVE
            and y.shape == self._shape
            and y.flags.c_contiguous
            and given.shape == self._given_shape
            and math.isfinite(time_s)
        ):
            _, y = checked_input(self.memory, self._n_y, given, np.asarray(time_s), y)
        memory, result = np.empty(self.memory.size), np.empty(self.result.size)
        self._step(
            self._self, _address(given), _address(memory), time_s, _address(y), _address(result)
        )
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        time_s, y = checked_input(self.memory, self._n_y, given, time_s, y)
        n = len(time_s)
        both = [given.copy(), np.empty_like(given)]
        results = np.empty((n, self.result.size))
        last = self._batch(
            self._self,
            _address(both[0]),
            _address(both[1]),
            n,
            _address(time_s),
            _address(y),
            _address(results),
        )
        return both[last], results

    def call(self, function: str, *arrays: Array) -> None:
        """Call another of the loop's functions with its structure and arrays."""
        entry = self._library[function]
        entry.argtypes = [ctypes.c_void_p] * (len(arrays) + 1)
        entry.restype = None
        entry(self._self, *(_address(array) for array in arrays))

    def _load(self, groups: Sequence[Sequence[ca.Function]]) -> dict[str, int]:
        """Return the address of every generated function."""
        addresses: dict[str, int] = {}
        for functions, path in zip(groups, function_libraries(groups), strict=True):
            library = ctypes.CDLL(str(path))
            self._kept.append(library)
            for function in functions:
                entry = library[function.name()]
                addresses[function.name()] = ctypes.cast(entry, ctypes.c_void_p).value or 0
        return addresses

    def _model(self, model: StateSpaceModel, addresses: Mapping[str, int]) -> Model:
        values = model_fields(model)
        return Model(*(self._c_value(k, value, addresses) for k, value in values.items()))

    def _c_value(self, name: str, value: Any, addresses: Mapping[str, int]) -> Any:
        """Return a value for C; arrays are kept alive as long as the engine."""
        match value:
            case None:
                return DOUBLES()
            case str():
                return ctypes.c_void_p(addresses[value])
            case bool() | int() | np.integer():
                return ctypes.c_longlong(int(value))
            case float():
                return ctypes.c_double(value)
            case ctypes.c_void_p():
                return value
            case np.ndarray():
                dtype, pointer = ARRAYS[value.dtype.kind]
                array = np.require(value, dtype=dtype, requirements="C")
                self._kept.append(array)
                return array.ctypes.data_as(pointer)
            case Mapping():
                members = {k: self._c_value(k, v, addresses) for k, v in value.items()}
                return _structure(name, members)
        raise TypeError(f"{name}: {type(value).__name__} has no C form")


ARRAYS: Mapping[str, tuple[type, type]] = {
    "f": (np.float64, DOUBLES),
    "i": (np.int64, INTEGERS),
    "b": (np.uint8, BYTES),
}
"""Kind of a NumPy array → its type and the pointer to it."""


def _structure(name: str, values: Mapping[str, Any]) -> ctypes.Structure:
    """Return a C structure of given values, named after its first capital."""
    fields = [(member, type(value)) for member, value in values.items()]
    kind = type(name.capitalize(), (ctypes.Structure,), {"_fields_": fields})
    return kind(*values.values())


def _loop_library(loop: Loop, structures: Sequence[type[ctypes.Structure]]) -> Path:
    """Compile a loop: it knows no model, so this happens once for all of them."""
    parts = [
        "#define _POSIX_C_SOURCE 199309L",
        "#define PEN_MHE_HOSTED",
        "typedef double real;",
        "typedef long long integer;",
        GENERATED,
        *(f"#define {name} {value!r}" for name, value in loop_constants(loop).items()),
        *(declaration(structure) for structure in structures),
        *engine_sources(loop),
    ]
    [library] = shared_libraries(["\n".join(parts)], STRICT)
    return library


def _address(array: Array) -> int:
    """Return the address of a contiguous array's first number."""
    try:  # four times as fast as the array interface
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
    except (TypeError, ValueError):  # read-only, or empty
        return int(array.__array_interface__["data"][0])
