"""The statistics of a watch as machine code: statistics.c, to the last bit, and clean.c."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from importlib import resources
from types import MappingProxyType
from typing import Any

import numpy as np

from estimation.machine import Machine, address, declared
from estimation.native import LOOPS, STRICT, CSource, shared_libraries
from estimation.watch.asked import Calmer, Known, Marks
from estimation.watch.limits import REPEATS_S
from estimation.watch.statistics import LIVELIER, Statistics
from models.arrays import Array

SOURCES = ("statistics.c", "clean.c")
CONSTANTS: Mapping[str, float] = MappingProxyType({"REPEATS_S": REPEATS_S, "LIVELIER": LIVELIER})
"""Macros of them."""


def statistics_fields(statistics: Statistics) -> dict[str, Any]:
    """Return the members of C's structure Statistics, but for the blocks of its memory.

    Of a sensor that is not watched limits are ones, which nobody reads.
    """
    model, windows = statistics.model, statistics.windows
    n, n_r = len(model.sensors), model.n_r
    watched = {each.index: each.limits for each in statistics.sensors}
    inertial = [each.index for each in statistics.sensors if each.is_inertial]
    squared = [
        x
        for i, sensor in enumerate(model.sensors)
        for x in (watched[i].squared if i in watched else (1.0,) * sensor.n_r)
    ]
    return {
        "n_sensors": n,
        "n_row": model.n_row,
        "n_r": n_r,
        "windows": windows,
        "first_row": np.cumsum([0, *(sensor.n_r for sensor in model.sensors)]),
        "first_column": np.cumsum([0, *(sensor.n_y for sensor in model.sensors)]),
        "is_watched": np.array([i in watched for i in range(n)]),
        "is_inertial": np.array([i in inertial for i in range(n)]),
        "repeats": np.array([watched[i].repeats if i in watched else 0 for i in range(n)]),
        "same": np.array([watched[i].same if i in watched else np.inf for i in range(n)]),
        "outliers": np.array(
            [float(watched[i].outliers) if i in watched else 1.0 for i in range(n)]
        ),
        "weights": np.array(
            [watched[i].weights if i in watched else (1.0,) * windows for i in range(n)]
        ),
        "limit": np.array(
            [watched[i].limit if i in watched else (1.0,) * 2 * windows for i in range(n)]
        ),
        "usual": np.array(
            [watched[i].usual if i in watched else (1.0,) * 2 * windows for i in range(n)]
        ),
        "squared": np.array(squared, dtype=float),
        "before": np.zeros(statistics.layout.size),
        "L": np.zeros((n_r, n_r)),
        "z": np.zeros(n_r),
        "far": np.zeros(n),
        "rows": np.zeros(n_r, dtype=np.int64),
    }


def statistics_structure(machine: Machine, statistics: Statistics) -> ctypes.Structure:
    """Return C's structure Statistics, with a workspace of its own."""
    fields = {"watch": statistics.layout.offsets(), **statistics_fields(statistics)}
    return machine.structure("Statistics", fields)


def watch_library(
    structures: Sequence[ctypes.Structure],
    *sources: str,
    constants: Mapping[str, float] = CONSTANTS,
) -> ctypes.CDLL:
    """Return C of this folder as machine code, as one.

    Parameters
    ----------
    structures : that it knows; those within one are declared in front of it
    """
    kinds = list[type[ctypes.Structure]]()
    for structure in structures:
        members = (getattr(structure, name) for name, *_ in structure._fields_)
        for each in (*members, structure):
            if isinstance(each, ctypes.Structure) and type(each) not in kinds:
                kinds.append(type(each))
    folder = resources.files("estimation.watch")
    texts = [(folder / source).read_text("utf-8") for source in sources]
    parts = [*declared(constants, kinds), *texts]
    [path] = shared_libraries([CSource("\n".join(parts), (*STRICT, *LOOPS))])
    return ctypes.CDLL(str(path))


class CompiledStatistics:
    """statistics.c for the sensors of a model, with a workspace of its own: one per thread."""

    def __init__(self, statistics: Statistics) -> None:
        self._machine = machine = Machine()
        structure = statistics_structure(machine, statistics)
        self._library = watch_library([structure], *SOURCES)
        pointer, real, integer = ctypes.c_void_p, ctypes.c_double, ctypes.c_longlong
        self._clean = self._library["watch_clean"]
        rows: list[Any] = [integer, *[pointer] * 3, integer, pointer, integer]
        self._clean.argtypes = [pointer, pointer, real, *rows, *[real] * 3]
        self._clean.restype = integer
        self._one = self._library["watch_one"]
        places, numbers = [pointer] * 3, [real] * 3
        self._one.argtypes = [*places, real, *places, integer, *places, pointer, pointer, *numbers]
        self._one.restype = integer
        self._again = self._library["watch_again"]
        again: list[Any] = [integer, *[pointer, integer] * 2, pointer, pointer]
        self._again.argtypes = [pointer, pointer, *again, real]
        self._again.restype = real
        self._self, self._size = ctypes.addressof(structure), statistics.layout.size

    def clean(
        self,
        memory: Array,
        time_s: Array,
        y: Array,
        v: Array,
        S: Array,
        *,
        newest_s: float,
        calmer: Calmer,
    ) -> int:
        """See `estimation.watch.quiet.Quiet.clean`."""
        given = [np.ascontiguousarray(each) for each in (time_s, y)]
        alive, rows = _rows(v, S)
        found: int = self._clean(
            self._self,
            address(memory),
            newest_s,
            len(time_s),
            *map(address, given),
            *rows,
            *calmer,
        )
        del alive
        return found

    def again(
        self, memory: Array, v: Array, S: Array, *, counts: Marks, judged: Marks, fewest: int
    ) -> float:
        """See `estimation.watch.quiet.Quiet.again`."""
        alive, rows = _rows(v, S)
        marks: list[Any] = [counts, judged]
        score: float = self._again(
            self._self, address(memory), len(v), *rows, *map(address, marks), fewest
        )
        del alive
        return score

    def one(
        self,
        memory: Array,
        time_s: float,
        y: Array,
        v: Array,
        S: Array,
        *,
        calmer: Calmer,
        known: Known,
    ) -> tuple[Array, Array] | None:
        """See `estimation.watch.quiet.Quiet.one`; arrays contiguous."""
        n_x = len(known.limit)
        after, std = np.empty(self._size), np.empty(n_x)
        is_clean = self._one(
            self._self,
            address(memory),
            address(after),
            time_s,
            address(y),
            address(v),
            address(S),
            n_x,
            address(known.covariance),
            address(known.limit),
            address(known.known.astype(float)),
            address(known.std),
            address(std),
            *calmer,
        )
        return (after, std) if is_clean else None


def _rows(*arrays: Array) -> tuple[list[Array], list[int]]:
    """Return arrays (n, …) with contiguous rows, and where each begins and how far rows are apart.

    The second is good as long as the first is alive.
    """
    kept, places = list[Array](), list[int]()
    for array in arrays:
        is_whole = array.strides[1:] == np.empty(array.shape[1:]).strides
        kept.append(array if is_whole else np.ascontiguousarray(array))
        start: int = kept[-1].__array_interface__["data"][0]
        places += [start, kept[-1].strides[0] // kept[-1].itemsize]
    return kept, places
