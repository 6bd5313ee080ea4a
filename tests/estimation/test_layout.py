"""Named blocks in a flat array: where they stand, and what C is told of them."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest

from estimation import native
from estimation.layout import Layout, declaration, offset_structure
from estimation.machine import Function
from estimation.result import result_layout
from tests.engines import needs_compiler
from tests.linear_models import coupled_system

LAYOUT = Layout("Example", {"count": (), "x": (3, 2), "none": (0, 4), "P": (2, 2), "last": ()})


def test_blocks_stand_one_behind_the_other() -> None:
    assert LAYOUT.size == 12
    flat, seen = np.arange(12.0), []
    for block, shape in LAYOUT.shapes.items():
        view = LAYOUT.view(flat, block)
        assert view.shape == shape
        seen += view.ravel().tolist()
    assert seen == flat.tolist()


def test_views_write_into_the_array() -> None:
    flat = np.zeros(LAYOUT.size)
    LAYOUT.view(flat, "P")[1, 0] = 5.0
    LAYOUT.view(flat, "count")[...] = 2.0
    assert flat[9] == 5.0
    assert flat[0] == 2.0
    assert flat.sum() == 7.0


def test_many_at_once() -> None:
    flat = np.arange(36.0).reshape(3, 12)
    assert LAYOUT.view(flat, "x").shape == (3, 3, 2)
    assert LAYOUT.view(flat, "last").shape == (3,)
    np.testing.assert_array_equal(LAYOUT.view(flat, "last"), [11, 23, 35])
    np.testing.assert_array_equal(LAYOUT.view(flat, "P")[1], [[19, 20], [21, 22]])


def test_offsets_are_the_views_places() -> None:
    offsets = LAYOUT.offsets()
    flat = np.arange(float(LAYOUT.size))
    for block in ("count", "x", "P", "last"):
        assert getattr(offsets, block) == LAYOUT.view(flat, block).ravel()[0]
    assert offsets.size == LAYOUT.size  # type: ignore[attr-defined]
    assert type(offsets).__name__ == "Example"


def test_declaration_names_every_field_and_its_type() -> None:
    kind = type(
        "Mixed",
        (ctypes.Structure,),
        {
            "_fields_": [
                ("n", ctypes.c_longlong),
                ("tolerance", ctypes.c_double),
                ("step", ctypes.c_void_p),
                ("table", ctypes.POINTER(ctypes.c_double)),
                ("rows", ctypes.POINTER(ctypes.c_longlong)),
                ("needs", ctypes.POINTER(ctypes.c_ubyte)),
                ("at", offset_structure("Example", ("count", "x"))),
            ]
        },
    )
    assert declaration(kind).splitlines() == [
        "typedef struct {",
        "    integer n;",
        "    real tolerance;",
        "    generated step;",
        "    real * table;",
        "    integer * rows;",
        "    unsigned char * needs;",
        "    Example at;",
        "} Mixed;",
    ]


@needs_compiler
def test_c_and_python_agree_where_a_field_stands(tmp_path: Path) -> None:
    """A program prints the places that the compiler gives to what is declared for it."""
    kinds = [Function, offset_structure("Result", tuple(LAYOUT.shapes))]
    fields = [(kind, name) for kind in kinds for name, *_ in kind._fields_]
    source = "\n".join(
        [
            "#include <stddef.h>",
            "#include <stdio.h>",
            "typedef double real;",
            "typedef long long integer;",
            "typedef int (*generated)(const real **, real **, integer *, real *, int);",
            *(declaration(kind) for kind in kinds),
            "int main(void) {",
            *(f'    printf("%zu\\n", offsetof({kind.__name__}, {name}));' for kind, name in fields),
            *(f'    printf("%zu\\n", sizeof({kind.__name__}));' for kind in kinds),
            "    return 0;",
            "}",
        ]
    )
    (tmp_path / "places.c").write_text(source)
    program = tmp_path / "places"
    compiler = native.compiler()
    assert compiler is not None
    subprocess.run([compiler, str(tmp_path / "places.c"), "-o", str(program)], check=True)
    said = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    wanted = [getattr(kind, name).offset for kind, name in fields]
    assert [int(line) for line in said.split()] == wanted + [ctypes.sizeof(k) for k in kinds]


def test_a_steps_result_has_all_it_says() -> None:
    layout = result_layout(coupled_system(3).model)
    assert layout.shapes["mean"] == (4,)
    assert layout.shapes["covariance"] == (4, 4)
    assert layout.shapes["innovation"] == (3,)
    assert layout.shapes["innovation_covariance"] == (3, 3)
    assert all(layout.shapes[name] == () for name in ("time_s", "status", "iterations", "cost"))


@pytest.mark.parametrize("block", ["missing", ""])
def test_an_unknown_block_is_a_mistake(block: str) -> None:
    with pytest.raises(KeyError):
        LAYOUT.view(np.zeros(LAYOUT.size), block)
