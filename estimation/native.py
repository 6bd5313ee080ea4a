"""From a CasADi function to machine code, kept between runs.

The generated C is compiled once and cached under a hash of source, compiler
and flags. Without a C compiler the function itself is returned: everything
works, slower, and a warning says so once.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
import warnings
from functools import cache
from pathlib import Path

import casadi as ca

FLAGS = ("-O1", "-fPIC", "-shared")
"""No -ffast-math: it breaks NaN."""


def cache_directory() -> Path:
    """Return where compiled functions are kept: ``PEN_MHE_CACHE`` or the user's cache."""
    if own := os.environ.get("PEN_MHE_CACHE"):
        return Path(own)
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "pen-mhe"


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
    gcc = compiler()
    if gcc is None:
        return function
    generator = ca.CodeGenerator("generated.c", {"with_header": False})
    generator.add(function)
    library = shared_library(generator.dump(), gcc)
    return ca.external(function.name(), str(library))


def shared_library(source: str, gcc: str) -> Path:
    """Compile C source to a shared library, or find it in the cache."""
    key = hashlib.sha256("\0".join((source, gcc, *FLAGS)).encode()).hexdigest()[:24]
    target = cache_directory() / f"{key}.so"
    if target.exists():
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
        code, built = Path(scratch) / "generated.c", Path(scratch) / "built.so"
        code.write_text(source)
        result = subprocess.run(
            [gcc, *FLAGS, str(code), "-o", str(built), "-lm"], capture_output=True, text=True
        )
        if result.returncode != 0:
            raise RuntimeError(f"{gcc} could not compile generated code: {result.stderr.strip()}")
        built.replace(target)  # atomic: two processes may build the same function
    return target
