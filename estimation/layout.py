"""Named blocks of numbers in one flat array, read by Python and by C alike.

An estimator's state is one such array: a copy of it is a copy of the state. C is
given the offsets as a structure whose declaration is derived from the same names.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from models.arrays import Array


class ArgumentRoom(ctypes.c_void_p):
    """Room for the pointers to a generated function's arguments."""


class KernelAddress(ctypes.c_void_p):
    """Address of a compiled stage's function."""


class ResultRoom(ctypes.c_void_p):
    """Room for the pointers to a generated function's results."""


C_TYPES: Mapping[object, str] = {
    ArgumentRoom: "const real **",
    ResultRoom: "real **",
    KernelAddress: "kernel",
    ctypes.c_longlong: "integer",
    ctypes.c_double: "real",
    ctypes.c_void_p: "generated",
    ctypes.POINTER(ctypes.c_double): "real *",
    ctypes.POINTER(ctypes.c_longlong): "integer *",
    ctypes.POINTER(ctypes.c_ubyte): "unsigned char *",
}
"""ctypes → C; a bare pointer is a generated function, a ``kernel`` any function. `real` and
`integer` are double and long long here, and whatever suits the machine in exported code."""


@dataclass(frozen=True)
class Layout:
    """Blocks of doubles, one behind the other.

    Parameters
    ----------
    name : of the C structure with the blocks' offsets
    shapes : block → shape, in the order of the blocks; () is one number
    """

    name: str
    shapes: Mapping[str, tuple[int, ...]]

    @cached_property
    def slices(self) -> Mapping[str, slice]:
        """Block → where it stands in the flat array."""
        slices, start = {}, 0
        for block, shape in self.shapes.items():
            slices[block] = slice(start, start + math.prod(shape))
            start += math.prod(shape)
        return slices

    @cached_property
    def size(self) -> int:
        """Length of the flat array."""
        return sum(math.prod(shape) for shape in self.shapes.values())

    def view(self, flat: Array, block: str) -> Array:
        """Return a block of a flat array (…, size) as a view (…, *shape)."""
        shape = (*flat.shape[:-1], *self.shapes[block])
        return flat[..., self.slices[block]].reshape(shape)

    def offsets(self) -> ctypes.Structure:
        """Return the offsets of all blocks, and the whole size, for C."""
        structure = offset_structure(self.name, tuple(self.shapes))
        return structure(*(part.start for part in self.slices.values()), self.size)


def offset_structure(name: str, blocks: tuple[str, ...]) -> type[ctypes.Structure]:
    """Return the C structure of a layout's offsets: one ``integer`` per block, and ``size``."""
    fields = [(block, ctypes.c_longlong) for block in (*blocks, "size")]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def declaration(structure: type[ctypes.Structure]) -> str:
    """Return the C declaration of a structure."""
    lines = [
        f"    {C_TYPES.get(kind) or kind.__name__} {field};"
        for field, kind, *_ in structure._fields_
    ]
    return "\n".join(["typedef struct {", *lines, f"}} {structure.__name__};"])
