"""From generated C to machine code, kept between runs.

C source is compiled once and cached under a hash of source, flags, compiler and
processor. Without a C compiler CasADi interprets the same functions: everything
works, slower, and a warning says so once. So it does where the cache cannot be written: then
every process compiles for itself.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import casadi as ca

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

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror")
"""For C written by hand."""


LOOPS = ("-ftree-loop-vectorize", "-fvect-cost-model=dynamic")
"""For plain loops over arrays of unknown length. -O3 would save two hundredths more of a pass and
take twice as long to compile."""
VECTORS = ("-O3", "-fno-tree-vectorize")
"""For the Kalman stage, whose C is written in vectors: where the compiler looks for more of them it
finds gathers, which are slower."""


def cache_directory() -> Path:
    """Return where compiled functions are kept: ``PEN_MHE_CACHE`` or the user's cache."""
    if own := os.environ.get("PEN_MHE_CACHE"):
        return Path(own)
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "pen-mhe"


@cache
def _writable(folder: Path) -> Path:
    """Return a folder; where it cannot be written, one of this process alone, after a warning."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        warnings.warn(
            f"cache {folder}: {error.strerror}, so compiled functions are lost when this process "
            "ends; PEN_MHE_CACHE names another folder",
            RuntimeWarning,
            stacklevel=2,
        )
    own = Path(tempfile.mkdtemp(prefix="pen-mhe-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own


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


@dataclass(frozen=True)
class CSource:
    """C99 of one shared library.

    Parameters
    ----------
    flags : the compiler's options in addition to `FLAGS`
    is_of_model : whether a model decides if it can be compiled
    """

    text: str
    flags: tuple[str, ...] = ()
    is_of_model: bool = False


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


class NotCompilableError(RuntimeError):
    """A generated function is no C that this machine can compile; the message says why."""


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
    """
    gcc = compiler()
    if gcc is None:
        raise RuntimeError("no C compiler found (CC, gcc, cc)")
    place = "\0".join((*_identity(gcc), processor()))
    targets = [_place(f"{_key(place, gcc, source)}.so") for source in sources]
    missing = {t: s for t, s in zip(targets, sources, strict=True) if not t.exists()}
    if missing:
        with _notice(), ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            list(pool.map(lambda pair: _build(gcc, pair[1], pair[0]), missing.items()))
    return targets


def _place(name: str) -> Path:
    """Return where a library is, or is to be built."""
    cached = cache_directory() / name
    return cached if cached.exists() else _writable(cached.parent) / name


def _key(place: str, gcc: str, source: CSource) -> str:
    told = "\0".join((place, gcc, *FLAGS, *source.flags, source.text))
    return hashlib.sha256(told.encode()).hexdigest()[:24]


def _build(gcc: str, source: CSource, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
        code, built = Path(scratch) / "generated.c", Path(scratch) / "built.so"
        code.write_text(source.text)
        arguments = [gcc, *FLAGS, *source.flags, str(code), "-o", str(built), "-lm"]
        result = subprocess.run(arguments, capture_output=True, text=True)
        if result.returncode != 0:
            kind = NotCompilableError if source.is_of_model else RuntimeError
            raise kind(f"{gcc} could not compile C: {result.stderr.strip()}")
        built.replace(target)  # atomic: two processes may build the same function


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
