"""From generated C to machine code, kept between runs.

C source is compiled once and cached under a hash of source, flags, compiler and
processor. Without a C compiler CasADi interprets the same functions: everything
works, slower, and a warning says so once. So it does where the cache cannot be written or is not
the user's own: then every process compiles for itself. What is damaged or does not load is
compiled again.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import os
import platform
import shutil
import sys
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import casadi as ca

from estimation.compile_c import CSource as CSource  # callers find it here
from estimation.compile_c import NotCompilableError as NotCompilableError
from estimation.compile_c import build
from estimation.compile_cache import (
    FORM,
    believed,
    cache_directory,
    is_whole,
    private_folder,
    writable,
)
from estimation.half_made import await_others
from models.errors import InputError

FLAGS = (
    *("-O2", "-march=native", "-ffp-contract=off", "-fno-math-errno"),
    *("-fno-semantic-interposition", "-fPIC", "-shared", "-fno-tree-slp-vectorize"),
    *("-fno-tree-pre", "-fno-code-hoisting", "-Wno-ignored-optimization-argument"),
)
"""No -ffast-math: it breaks NaN. No contraction: machine code and CasADi's virtual machine then
round alike, to the last bit, and it gains nothing that shows. No vectors of what stands side by
side: gcc 12 contracts pairs of a sum and a difference there, whatever it is told. Without semantic
interposition generated functions inline their own helpers, which saves a seventh. No search for
partial redundancies: straight-line code has next to none, and looking for them is half of the
compiler's time (clang does not know these two options, and is told not to mind)."""

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
"""For C written by hand, and for exports."""


LOOPS = ("-ftree-loop-vectorize", "-fvect-cost-model=dynamic")
"""For plain loops over arrays of unknown length. -O3 would save two hundredths more of a pass and
take twice as long to compile."""
VECTORS = ("-O3", "-fno-tree-vectorize")
"""For the Kalman stage, whose C is written in vectors: where the compiler looks for more of them it
finds gathers, which are slower."""


@cache
def compiler() -> str | None:
    """Return the C compiler (``CC``, else gcc, else cc), or None after one warning."""
    for name in (os.environ.get("CC"), "gcc", "cc"):
        if name and (path := shutil.which(name)):
            return path
    warnings.warn(
        "no C compiler found (CC, gcc, cc): functions are interpreted, which is slower",
        RuntimeWarning,
        stacklevel=2,
    )
    return None


@cache
def processor() -> str:
    """Return what tells processors apart that do not run each other's machine code."""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        told = [x for x in lines if x.split("\t")[0] in ("vendor_id", "model name", "flags")]
        if told:
            return "\n".join(sorted(set(told)))
    return f"{platform.machine()} {platform.processor()}"


def compiled(function: ca.Function) -> ca.Function:
    """Return the function as machine code, or itself where there is no compiler.

    Parameters
    ----------
    function : any CasADi function that can be generated as C

    Raises
    ------
    RuntimeError
        If the compiler rejects the generated code; the message is its own.
    """
    if compiler() is None:
        return function
    [library] = shared_libraries([CSource(generated([function]))])
    return ca.external(function.name(), str(library))


def generated(functions: Sequence[ca.Function]) -> str:
    """Return the C of functions."""
    generator = ca.CodeGenerator("generated.c", {"with_header": False})
    try:
        for function in functions:
            generator.add(function)
        return generator.dump()
    except RuntimeError as error:
        raise NotCompilableError(f"CasADi writes no C: {error}") from None


def shared_libraries(sources: Sequence[CSource]) -> list[Path]:
    """Compile C to shared libraries side by side, or find them in the cache.

    Raises
    ------
    RuntimeError
        If there is no compiler, or if it rejects the code; the message is its own.
    InputError
        If there is no room for what is compiled.
    """
    gcc = compiler()
    if gcc is None:
        raise RuntimeError("no C compiler found (CC, gcc, cc)")
    place = "\0".join((*_identity(gcc), processor()))
    targets = [_place(f"{_key(place, gcc, source)}.so") for source in sources]
    by_target = dict(zip(targets, sources, strict=True))
    missing = [target for target in by_target if not _is_usable(target)]
    if missing:
        with _notice(), ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            list(pool.map(lambda target: _build_once(gcc, by_target[target], target), missing))
    return [_loading(gcc, by_target[target], target) for target in targets]


def _build_once(gcc: str, source: CSource, target: Path) -> None:
    """Compile C, or wait for another process that is compiling the same."""
    await_others(target)
    if not is_whole(target):
        build((gcc, *FLAGS), source, target)


_loaded: dict[Path, Path] = {}
"""Where a library belongs → the file of it that is loaded, which is not looked at again."""


def _place(name: str) -> Path:
    """Return where a library is, or is to be built."""
    folder = believed(cache_directory())
    return (folder if (folder / name).exists() else writable(folder)) / name


def _is_usable(target: Path) -> bool:
    if not target.exists():
        return False
    if target in _loaded or is_whole(target):
        return True
    _say_again(target, "damaged")
    return False


def _loading(gcc: str, source: CSource, target: Path) -> Path:
    """Return a library that loads: compiled again, then elsewhere, where the one there does not."""
    if target in _loaded and _loaded[target].exists():
        return _loaded[target]
    elsewhere = private_folder() / target.name
    reason = None
    for path, is_new in ((target, False), (target, True), (elsewhere, True)):
        try:
            if is_new:
                build((gcc, *FLAGS), source, path)
            ctypes.CDLL(str(path))
        except (OSError, InputError) as error:
            if reason is None:
                _say_again(target, reason := str(error))
            continue
        _loaded[target] = path
        return path
    raise RuntimeError(f"no library of {target.parent} or {elsewhere.parent} loads: {reason}")


def _say_again(target: Path, reason: str) -> None:
    sentence = f"cache {target}: {reason}, so it is compiled again"
    warnings.warn(sentence, RuntimeWarning, stacklevel=4)


def _key(place: str, gcc: str, source: CSource) -> str:
    told = "\0".join((FORM, place, gcc, *FLAGS, *source.flags, source.text))
    return hashlib.sha256(told.encode()).hexdigest()[:24]


@cache
def _identity(gcc: str) -> tuple[str, str, str]:
    """Return what changes with the compiler, without running it."""
    path = Path(gcc).resolve()
    return str(path), str(path.stat().st_size), str(path.stat().st_mtime_ns)


@contextlib.contextmanager
def _notice() -> Iterator[None]:
    """Say on a terminal that a compilation is going on, and be quiet elsewhere."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console  # only for a wait on a terminal

    with Console(stderr=True).status("compiling the model's functions (once, then cached) …"):
        yield
