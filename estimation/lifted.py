"""Numbers of a function as an argument of their own: what is compiled is the same for all values.

Two pens of one shape differ in lengths, levels and directions. Where these stand in the code each
pen has a code of its own, to be compiled for seconds; as an argument they are data.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from estimation.native import generated
from models.arrays import Array

KEPT = (0.0, 1.0, -1.0)
"""Numbers that stay in the code: formulas have them, whatever the pen."""
NAME = "constants"


@dataclass(frozen=True, eq=False)
class Lifted:
    """A function (…, constants (n,)) and the constants with which it is the one that was given."""

    function: ca.Function
    constants: Array

    @cached_property
    def code(self) -> str:
        """The C of the function."""
        return generated([self.function])


@lru_cache(maxsize=128)
def lifted(function: ca.Function) -> Lifted:
    """Return a function of scalars (SX) with its numbers as the last argument.

    One that calls others (a lookup table, an integrator) keeps its numbers: it gets an argument
    without entries.
    """
    arguments = [
        ca.SX.sym(name, function.sparsity_in(i)) for i, name in enumerate(function.name_in())
    ]
    names = [*function.name_in(), NAME], function.name_out()
    if not is_plain(function):
        empty = ca.SX.sym(NAME, 0)
        results = function.call(arguments)
        return Lifted(ca.Function(function.name(), [*arguments, empty], results, *names), _none())
    codes = range(function.n_instructions())
    values = [
        function.instruction_constant(k) for k in codes if function.instruction_id(k) == ca.OP_CONST
    ]
    constants = list(dict.fromkeys(value for value in values if value not in KEPT))
    symbols = ca.SX.sym(NAME, len(constants))
    place = {value: symbols[i] for i, value in enumerate(constants)}
    results = _followed(function, arguments, place)
    made = ca.Function(function.name(), [*arguments, symbols], results, *names)
    return Lifted(made, np.array(constants))


def _none() -> Array:
    return np.zeros(0)


@lru_cache(maxsize=128)
def is_plain(function: ca.Function) -> bool:
    """Whether all instructions are scalar ones: in C these need no workspace."""
    return function.is_a("SXFunction") and all(
        function.instruction_id(k) != ca.OP_CALL for k in range(function.n_instructions())
    )


def _followed(
    function: ca.Function, arguments: list[ca.SX], place: dict[float, ca.SX]
) -> list[ca.SX]:
    """Return the function's results by following its instructions."""
    given: list[Any] = [argument.nonzeros() for argument in arguments]
    found = [[ca.SX(0)] * function.nnz_out(i) for i in range(function.n_out())]
    work: dict[int, ca.SX] = {}
    for k in range(function.n_instructions()):
        code: Any = function.instruction_id(k)
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_CONST:
            value = function.instruction_constant(k)
            work[outputs[0]] = place.get(value, ca.SX(value))
        elif code == ca.OP_INPUT:
            work[outputs[0]] = given[inputs[0]][inputs[1]]
        elif code == ca.OP_OUTPUT:
            found[outputs[0]][outputs[1]] = work[inputs[0]]
        elif len(inputs) == 1:
            work[outputs[0]] = ca.SX.unary(code, work[inputs[0]])
        else:
            work[outputs[0]] = ca.SX.binary(code, work[inputs[0]], work[inputs[1]])
    return [
        ca.SX(function.sparsity_out(i), ca.vertcat(ca.SX(0, 1), *entries))
        for i, entries in enumerate(found)
    ]
