"""The loops of estimators in compiled C, called through addresses.

An estimator's state is one flat array (a `Layout`), and so is what a step says. An
`Engine` makes one from the other; where there is no C compiler, the estimator brings an
engine in Python around the same symbolic stages.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

from estimation.loop import FORM_BEHIND_POINTERS, engine_sources, loop_constants, model_fields
from estimation.loop import Loop as Loop  # mhe takes it from here
from estimation.machine import Function, Machine, address, declared, kernel, kernel_fields
from estimation.native import LOOPS, STRICT, CSource
from estimation.result import checked_input, result_layout
from estimation.stored import QUAD
from models.arrays import Array
from models.state_space import StateSpaceModel

NATIVE = np.dtype(np.float64)


class CompiledEngine:
    """A loop as machine code, with a workspace of its own: one per thread."""

    def __init__(self, model: StateSpaceModel, loop: Loop) -> None:
        self.memory, self.result = loop.memory, result_layout(model, loop.lags)
        self._model, self._shape, self._given_shape = model, (model.n_row,), (loop.memory.size,)
        self._machine = machine = Machine()
        described = machine.structure("Model", {**model_fields(model, loop), **kernel_fields()})
        offsets = {"memory": loop.memory.offsets(), "result": self.result.offsets()}
        fields = {"model": described, **offsets, **loop.fields}
        structure = machine.structure(loop.entry.capitalize(), fields)
        own: Any = structure  # its members are known by the loop only
        stage = kernel(model, type(described))
        [library] = machine.load(
            loop.functions, [own.model, own], [stage, _loop_source(loop, structure)]
        )
        self._self = ctypes.addressof(structure)
        pointer = ctypes.c_void_p
        self._step = library[f"{loop.entry}_step"]
        self._step.argtypes = [pointer, pointer, pointer, ctypes.c_double, pointer, pointer]
        self._step.restype = None
        self._batch = library[f"{loop.entry}_batch"]
        self._batch.argtypes = [pointer, pointer, pointer, ctypes.c_longlong, *[pointer] * 3]
        self._library = library

    @property
    def addresses(self) -> tuple[int, int]:
        """Of its structure and of its step, for other C."""
        return self._self, ctypes.cast(self._step, ctypes.c_void_p).value or 0

    def step(self, given: Array, time_s: float, y: Array) -> tuple[Array, Array]:
        """Return the state after a measurement and what the step says; `given` stays."""
        if not (
            y.dtype is NATIVE
            and y.shape == self._shape
            and given.shape == self._given_shape
            and math.isfinite(time_s)
            and not self._model.n_u
        ):
            _, y = checked_input(self.memory, self._model, given, np.asarray(time_s), y)
        memory, result = np.empty(self.memory.size), np.empty(self.result.size)
        row = y.tobytes()  # faster than its address
        self._step(self._self, address(given), address(memory), time_s, row, address(result))
        return memory, result

    def batch(self, given: Array, time_s: Array, y: Array) -> tuple[Array, Array]:
        """Return the state after n measurements and what each step says, (n, result.size)."""
        time_s, y = checked_input(self.memory, self._model, given, time_s, y)
        n = len(time_s)
        both = [given.copy(), np.empty_like(given)]
        results = np.empty((n, self.result.size))
        last = self._batch(
            self._self,
            address(both[0]),
            address(both[1]),
            n,
            address(time_s),
            address(y),
            address(results),
        )
        return both[last], results

    def call(self, function: str, *arrays: Array) -> None:
        """Call another of the loop's functions with its structure and arrays."""
        entry = self._library[function]
        entry.argtypes = [ctypes.c_void_p] * (len(arrays) + 1)
        entry.restype = None
        entry(self._self, *(address(array) for array in arrays))


def _loop_source(loop: Loop, structure: ctypes.Structure) -> CSource:
    """Return the C of a loop: it knows no model, so this is compiled once for all of them."""
    members = [getattr(structure, name) for name, *_ in structure._fields_]
    nested = [
        type(member)
        for member in members
        if isinstance(member, ctypes.Structure) and not isinstance(member, Function)
    ]
    parts = [
        *declared({"QUAD": QUAD, **loop_constants(loop)}, [*nested, type(structure)]),
        *engine_sources(loop, FORM_BEHIND_POINTERS),
    ]
    return CSource("\n".join(parts), (*STRICT, *LOOPS))
