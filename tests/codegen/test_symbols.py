"""What object files need and offer: no dynamic memory, no clock, no doubles in single precision."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from codegen.export import export_texts
from codegen.exportable import exportable
from mhe.compiled.loop import FUNCTIONS_OF
from models.state_space import StateSpaceModel
from tests.codegen.exports import made
from tests.codegen.toolchains import CORTEX, HOST, TOOLCHAINS, Toolchain, compile_strictly, symbols
from tests.engines import needs_compiler
from tests.estimation import pens

PEN = pens.draw_pen_run(20, seed=11).model
ALLOCATION = {"malloc", "calloc", "realloc", "free", "sbrk", "_sbrk"}
FILES = ("pen.o", "pen_model.o")
DOUBLE_MATH = {"sin", "cos", "sqrt", "atan2", "fabs", "ceil", "fmax", "fmin", "copysign"}
TIME_ONLY = {
    *("__aeabi_dadd", "__aeabi_dsub", "__aeabi_d2f", "__aeabi_f2d"),
    *("__aeabi_dcmplt", "__aeabi_dcmpgt", "__aeabi_dcmpun", "__aeabi_dcmple", "__aeabi_dcmpge"),
}
"""What handing over a time as double takes: a difference, a comparison, a conversion."""
MATHEMATICS = {
    "atan2",
    "ceil",
    "copysign",
    "cos",
    "fmax",
    "fmin",
    "nextafter",
    "sin",
    "sincos",
    "sqrt",
}
ALLOWED = {"memcmp", "memcpy", "memmove", "memset", "_GLOBAL_OFFSET_TABLE_", *MATHEMATICS}


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_needs_no_memory_and_no_operating_system(
    chain: Toolchain, name: str, real: str, tmp_path: Path
) -> None:
    compile_strictly(chain, made(name, PEN, real, "root"), tmp_path)
    needed = set().union(*(symbols(chain, tmp_path, file, "-u") for file in FILES))
    assert not needed & ALLOCATION
    own = {symbol for symbol in needed if symbol.startswith(("pen_", "__aeabi_"))}
    assert {symbol.removesuffix("f") for symbol in needed - own} <= ALLOWED
    offered = set().union(*(symbols(chain, tmp_path, file, "-g") for file in FILES)) - needed
    assert offered >= {"pen_init", "pen_step"}
    assert all(symbol.startswith("pen_") for symbol in offered), offered


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_single_precision_has_doubles_in_times_only(
    chain: Toolchain, name: str, tmp_path: Path
) -> None:
    compile_strictly(chain, made(name, PEN, "float"), tmp_path)
    model, loop = (symbols(chain, tmp_path, file, "-u") for file in ("pen_model.o", "pen.o"))
    assert not (model | loop) & DOUBLE_MATH
    assert not [symbol for symbol in model if symbol.startswith("__aeabi_d")]
    if chain is CORTEX:
        doubles = {s for s in loop if s.startswith("__aeabi_d") or s.endswith("2d")}
        assert doubles <= TIME_ONLY


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize(
    ("model", "settings", "parts"),
    [
        (PEN, {}, set()),
        (PEN.bounded(tip_z_m=(-1.0, np.inf)), {}, {"CONSTRAINED"}),
        (PEN, {"sparse_noise": 1.0}, {"LOSSES"}),
    ],
    ids=["plain", "bounded", "sparse noise"],
)
def test_only_what_is_used_is_in_it(
    chain: Toolchain,
    model: StateSpaceModel,
    settings: dict[str, float],
    parts: set[str],
    tmp_path: Path,
) -> None:
    export = made("mhe-rti", model, settings={"horizon": 2, **settings})
    compile_strictly(chain, export, tmp_path, ("-O0",))
    offered = symbols(chain, tmp_path, "pen_model.o", "-g")
    for part, functions in FUNCTIONS_OF.items():
        assert {f"pen_{name}" in offered for name in functions} == {part in parts}


@pytest.mark.parametrize("chain", TOOLCHAINS)
def test_a_clock_of_ones_own(chain: Toolchain, tmp_path: Path) -> None:
    """Its name is given; nothing else is needed of the machine."""
    export = made("mhe-rti", PEN, "float", settings={"horizon": 2, "deadline_s": 0.001})
    compile_strictly(chain, export, tmp_path, ("-Os", "-DPEN_MHE_CLOCK=my_seconds"))
    needed = symbols(chain, tmp_path, "pen.o", "-u")
    assert "my_seconds" in needed
    assert "clock_gettime" not in needed
    with pytest.raises(AssertionError, match="a deadline needs a clock"):
        compile_strictly(chain, export, tmp_path, ("-Os",))


@needs_compiler
def test_two_exports_live_side_by_side(tmp_path: Path) -> None:
    offered = []
    for prefix in ("left", "right"):
        (tmp_path / prefix).mkdir()
        export = export_texts(exportable("ekf", PEN), "float", prefix=prefix)
        compile_strictly(HOST, export, tmp_path / prefix)
        files = (f"{prefix}.o", f"{prefix}_model.o")
        undefined = set().union(*(symbols(HOST, tmp_path / prefix, f, "-u") for f in files))
        both = set().union(*(symbols(HOST, tmp_path / prefix, f, "-g") for f in files))
        offered.append(both - undefined)
    assert not offered[0] & offered[1]
