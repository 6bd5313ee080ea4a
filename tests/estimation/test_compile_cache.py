"""No library is loaded that is not whole, and none that somebody else may have put there."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from estimation import compile_c, compile_cache, native
from estimation.compile_cache import is_whole, write_sealed
from models.errors import InputError
from tests.engines import needs_compiler
from tests.rooms_to_write import room_for

pytestmark = needs_compiler

ROOT = Path(__file__).parents[2]
SCRIPT = """
import sys, warnings
import numpy as np
from tests.estimation.test_compile_cache import FACTORS, small_function
from estimation import native

warnings.simplefilter("always")
for factor in FACTORS:
    print(native.compiled(small_function(factor))(np.ones(3)))
"""


def small_function(factor: float) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x)])


def built(factor: float) -> Path:
    [path] = native.shared_libraries([native.CSource(native.generated([small_function(factor)]))])
    return path


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda library: b"",
    "half": lambda library: library[: len(library) // 2],
    "its last byte is missing": lambda library: library[:-1],
    "its seal is missing": lambda library: library[:-32],
    "a bit": lambda library: library[:5000] + bytes([library[5000] ^ 1]) + library[5001:],
    "a hole": lambda library: library[:4096] + bytes(len(library) - 4096),
    "something else": lambda library: b"no library" * 100,
}
FACTORS = tuple(float(number) for number in range(2, 2 + len(DAMAGE)))


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PEN_MHE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(native, "_loaded", {})
    return tmp_path / "cache"


def replace(path: Path, content: bytes) -> None:
    """Not in place: this process has the old one in its memory."""
    path.with_suffix(".new").write_bytes(content)
    path.with_suffix(".new").replace(path)


def test_what_is_damaged_is_compiled_again_and_never_loaded(own_cache: Path) -> None:
    """In a process of its own: half a library ends it without a word."""
    for factor, damage in zip(FACTORS, DAMAGE.values(), strict=True):
        path = built(factor)
        assert is_whole(path)
        replace(path, damage(path.read_bytes()))
        assert not is_whole(path)
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=ROOT, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    values = [f"[{', '.join([f'{factor * np.sin(1):.6g}'] * 3)}]" for factor in FACTORS]
    assert result.stdout.split("\n")[:-1] == values
    assert result.stderr.count("damaged, so it is compiled again") == len(DAMAGE)
    assert all(is_whole(path) for path in own_cache.iterdir())
    assert len(list(own_cache.iterdir())) == len(DAMAGE)


def test_files_of_another_layout_are_not_called_damaged(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    """As those that a version without checksums left there."""
    with monkeypatch.context() as patch:
        patch.setattr(native, "FORM", "library")
        old = built(2.0)
    old.write_bytes(old.read_bytes()[:-32])
    assert built(2.0) != old
    assert not recwarn.list


def test_a_whole_one_that_does_not_load_is_compiled_again(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:  # what is loaded is found by its name
        patch.setattr(native.ctypes, "CDLL", lambda name: None)
        path = built(2.0)
    path.unlink()
    write_sealed(b"made for another machine", path)
    monkeypatch.setattr(native, "_loaded", {})
    with pytest.warns(RuntimeWarning, match="so it is compiled again") as told:
        assert built(2.0) == path
    assert len(told) == 1
    assert is_whole(path)


def test_where_nothing_loads_another_folder_is_tried(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a medium that may not be executed."""
    load = native.ctypes.CDLL

    def refuse(name: str) -> object:
        if name.startswith(str(own_cache)):
            raise OSError("failed to map segment from shared object")
        return load(name)

    monkeypatch.setattr(native.ctypes, "CDLL", refuse)
    with pytest.warns(RuntimeWarning, match="failed to map segment") as told:
        paths = [built(3.0) for _ in range(2)]
    assert len(told) == 1
    [path] = set(paths)
    assert path.parent == compile_cache.private_folder()
    monkeypatch.setattr(native.ctypes, "CDLL", lambda name: refuse(str(own_cache)))
    with pytest.warns(RuntimeWarning), pytest.raises(RuntimeError, match=r"no library of .* loads"):
        built(4.0)


def test_the_folder_is_the_users_own(own_cache: Path) -> None:
    built(2.0)
    assert stat.S_IMODE(own_cache.stat().st_mode) == 0o700
    own_cache.chmod(0o755)  # what others may only read is closed to them
    built(2.0)
    assert stat.S_IMODE(own_cache.stat().st_mode) == 0o700


FOREIGN = {
    "belongs to another user": lambda folder, patch: patch.setattr(os, "geteuid", lambda: 4711),
    "can be written by others": lambda folder, patch: folder.chmod(0o770),
}


@pytest.mark.parametrize("reason", FOREIGN)
def test_nothing_of_a_foreign_folder_is_loaded(
    reason: str, own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    planted = built(2.0)
    monkeypatch.setattr(native, "_loaded", {})
    FOREIGN[reason](own_cache, monkeypatch)
    mode = own_cache.stat().st_mode
    with pytest.warns(RuntimeWarning, match=f"cache {own_cache}: {reason}, so compiled") as told:
        paths = [built(2.0), built(3.0), built(2.0)]
    assert len(told) == 1
    assert {path.parent for path in paths} == {compile_cache.private_folder()}
    assert stat.S_IMODE(compile_cache.private_folder().stat().st_mode) == 0o700
    assert own_cache.stat().st_mode == mode
    assert list(own_cache.iterdir()) == [planted]


def test_no_room_is_a_sentence(own_cache: Path) -> None:
    for size in (100, 6000):  # for the source, and for what is made of it
        with room_for(size), pytest.raises(InputError) as raised:
            built(9.0)
        said = str(raised.value)
        assert said.startswith(f"cache {own_cache}: File ")
        assert said.endswith(
            ", expected room for compiled functions; PEN_MHE_CACHE names another folder"
        )
        assert list(own_cache.iterdir()) == []


def test_what_a_killed_build_left_goes(own_cache: Path) -> None:
    path = built(2.0)
    path.unlink()
    left = own_cache / f".{path.name}.0123abcd.part"
    left.mkdir()
    (left / "generated.c").touch()
    built(2.0)
    assert list(own_cache.iterdir()) == [path]


def test_what_another_process_compiles_is_waited_for(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Locks of two threads are as those of two processes: each has its own descriptor."""
    compiling, made = threading.Event(), []
    original = compile_c._library

    def library(compiler: Sequence[str], source: native.CSource, scratch: Path) -> bytes:
        made.append(scratch)
        compiling.set()
        time.sleep(0.2)
        return original(compiler, source, scratch)

    monkeypatch.setattr(compile_c, "_library", library)
    with ThreadPoolExecutor(2) as both:
        first = both.submit(built, 1.5)
        assert compiling.wait(30)
        second = both.submit(built, 1.5)
        assert first.result() == second.result()
    assert len(made) == 1
