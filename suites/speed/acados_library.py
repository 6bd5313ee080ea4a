"""acados where it is installed: its Python interface and its libraries, loaded in silence.

The package ``comma-deps-acados`` brings a cut-down CasADi that overwrites the one of its
environment, so it goes into a folder of its own, of which only ``acados/`` is used:

    pip install --no-deps --target FOLDER comma-deps-acados
    export PEN_MHE_ACADOS=FOLDER
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from estimation import native
from suites.speed.contender import ContenderAbsentError, in_silence

FOLDER = "PEN_MHE_ACADOS"
"""Environment variable: where the package was put."""
PACKAGE = "comma-deps-acados"
LIBRARIES = ("libqpOASES_e", "libblasfeo", "libhpipm", "libacados")
"""In the order in which they need each other."""


@dataclass(frozen=True)
class AcadosLibrary:
    """acados, ready to build solvers.

    Parameters
    ----------
    interface : its Python module
    installed : folder with ``include``, ``lib`` and ``bin``
    version : of the package
    """

    interface: Any
    installed: Path
    version: str


def acados_library() -> AcadosLibrary:
    """Load acados.

    Raises
    ------
    ContenderAbsentError
        If it is not installed, or there is no C compiler for what it generates.
    """
    folder = os.environ.get(FOLDER)
    if not folder or not (Path(folder) / "acados").is_dir():
        raise ContenderAbsentError(f"acados is not installed ({FOLDER} names no folder with it)")
    if native.compiler() is None:
        raise ContenderAbsentError("acados needs a C compiler")
    return _loaded(folder)


@cache
def _loaded(folder: str) -> AcadosLibrary:
    installed = Path(folder).resolve() / "acados" / "install"
    ending = ".dylib" if sys.platform == "darwin" else ".so"
    try:
        for name in LIBRARIES:
            # Known to the loader by name from here on, and its symbols to nobody else: fatrop
            # has a BLASFEO of its own.
            ctypes.CDLL(str(installed / "lib" / f"{name}{ending}"))
        with in_silence(), _importable(folder):
            interface = importlib.import_module("acados.acados_template")
    except (ImportError, OSError) as error:
        raise ContenderAbsentError(f"acados cannot be loaded ({error})") from None
    found = next(iter(distributions(name=PACKAGE, path=[folder])), None)
    return AcadosLibrary(interface, installed, f"{PACKAGE} {found.version if found else '?'}")


@contextmanager
def quietly_building(library: AcadosLibrary) -> Iterator[None]:
    """Let acados find its parts; what it, its template renderer and make print is not shown."""
    # Names of acados alone, which it reads at every turn.
    os.environ["ACADOS_SOURCE_DIR"] = str(library.installed)
    os.environ["ACADOS_PYTHON_INTERFACE_PATH"] = str(library.installed.parent / "acados_template")
    os.environ["TERA_PATH"] = str(library.installed / "bin" / "t_renderer")
    directory = Path.cwd()
    sys.stdout.flush()
    kept = [os.dup(stream) for stream in (1, 2)]
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.chdir(directory)
        sys.stdout.flush()
        for stream, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, stream)
            os.close(copy)


@contextmanager
def _importable(folder: str) -> Iterator[None]:
    """Look for modules in a folder too, after all others: its CasADi must not be found."""
    sys.path.append(folder)
    try:
        yield
    finally:
        sys.path.remove(folder)
