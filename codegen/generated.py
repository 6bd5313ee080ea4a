"""The functions that CasADi writes, as one C file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from codegen.number_format import Precision

QUIET = """#if defined __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif"""
LOUD = """#if defined __GNUC__
#pragma GCC diagnostic pop
#endif
"""
"""CasADi's functions all have the same arguments, and rarely need them all."""
SIGNATURE = "int {}(const real **, real **, integer *, real *, int);"


def named(function: ca.Function, name: str) -> ca.Function:
    """Return the same function under another name."""
    arguments = function.sx_in()
    names = function.name_in(), function.name_out()
    return ca.Function(name, arguments, function.call(arguments), *names, {"cse": True})


def generated_source(functions: Sequence[ca.Function], prefix: str, precision: Precision) -> str:
    """Return the C of functions, each behind a prefix.

    No number of it is a double and no function of <math.h> a double's in single precision.
    """
    options: Any = {
        "with_header": False,
        "casadi_real": precision.c_type,
        "casadi_int": "int",
    }
    generator = ca.CodeGenerator(f"{prefix}_model.c", options)
    for function in functions:
        generator.add(named(function, f"{prefix}_{function.name()}"))
    source = precision.literals(generator.dump())
    top = ["#include <math.h>", *precision.functions([source])]
    return "\n".join([*top, "", QUIET, source, LOUD])


def prototypes(functions: Sequence[ca.Function], prefix: str) -> list[str]:
    """Return the functions' declarations for the loops."""
    return [SIGNATURE.format(f"{prefix}_{function.name()}") for function in functions]
