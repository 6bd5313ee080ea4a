"""Flash and memory of an export are measured, and told in its README."""

from __future__ import annotations

import ctypes
import re
import shutil

import pytest

from codegen.estimate_fields import estimate_fields, estimate_structure
from codegen.folder import export_files
from codegen.sizes import Sizes, Target, find_target, measure, size_words
from estimation import native
from estimation.result import result_layout
from tests.codegen.exports import made
from tests.codegen.toolchains import TOOLCHAINS, Toolchain
from tests.engines import needs_compiler
from tests.mhe import pendulum

C_TYPES = {"double": ctypes.c_double, "float": ctypes.c_float}
MODEL = pendulum.model()

pytestmark = pytest.mark.usefixtures("optimised")


def target(chain: Toolchain) -> Target:
    is_bare = chain.command[0] != "gcc"
    return Target("x", chain.command, chain.nm.replace("nm", "size"), chain.nm, is_bare)


@pytest.mark.cover
@pytest.mark.parametrize("chain", TOOLCHAINS)
@pytest.mark.parametrize(
    ("real", "c_type"), [("double", ctypes.c_double), ("float", ctypes.c_float)]
)
def test_memory_is_what_the_structures_take(chain: Toolchain, real: str, c_type: type) -> None:
    export = made("ekf", MODEL, real)
    sizes = measure(export, target(chain))
    structure = estimate_structure(estimate_fields(result_layout(MODEL)), c_type)
    numbers = 2 * export.exported.loop.memory.size * ctypes.sizeof(c_type)
    assert sizes.estimate == ctypes.sizeof(structure)
    assert numbers < sizes.state <= numbers + 4 * 8 + 2 * 4
    assert 0 < sizes.ram < 4096
    assert 1000 < sizes.flash < 64_000
    assert 0 < sizes.stack < 4096


@pytest.mark.parametrize("chain", TOOLCHAINS)
def test_a_longer_window_takes_more_memory_and_no_more_code(chain: Toolchain) -> None:
    short, long = (
        measure(made("mhe-rti", MODEL, "float", settings={"horizon": n}), target(chain))
        for n in (5, 25)
    )
    assert long.ram > 2 * short.ram
    assert long.state > 2 * short.state
    # Tables with a number per stage are all that flash grows by.
    assert 0 <= long.flash - short.flash <= 20 * 4 * (MODEL.n_w + 2)


@needs_compiler
def test_the_readme_tells_what_was_measured_and_with_what() -> None:
    export = made("ekf", MODEL, "float")
    found = find_target()
    assert found is not None
    assert ("Cortex-M4F" in found.words) == (shutil.which("arm-none-eabi-gcc") is not None)
    sizes = measure(export, found)
    readme = export_files(export, sizes, "pen-mhe codegen")["README.md"]
    assert found.words in readme
    for number in (sizes.flash, sizes.ram, sizes.state, sizes.estimate, sizes.stack):
        assert f"| {number} B |" in readme
    assert not re.search(r"@\w", readme)


def test_without_a_compiler_nothing_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "compiler", lambda: None)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert find_target() is None
    assert "Not measured" in size_words(None)


def test_words() -> None:
    words = size_words(Sizes("a machine", 1, 2, 3, 4, 5))
    assert words.startswith("Measured for a machine:")
    assert [int(n) for n in re.findall(r"(\d) B", words)] == [1, 2, 3, 4, 5]
