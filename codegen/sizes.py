"""What an export takes of a machine: flash and memory, measured with a compiler."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from codegen.export import Export
from codegen.exportable import is_timed
from codegen.template import filled
from estimation import native
from estimation.compile_c import lack_of_room
from models.errors import InputError

ARM = "arm-none-eabi-"
CORTEX_M4F = ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
SMALL = ("-Os", "-std=c99", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections")


@dataclass(frozen=True)
class Target:
    """A machine to measure for: words for people, compiler with flags, its ``size`` and ``nm``."""

    words: str
    command: tuple[str, ...]
    size: str
    nm: str
    is_bare: bool


@dataclass(frozen=True)
class Sizes:
    """Bytes that an export takes.

    Parameters
    ----------
    target : the compiler, in words
    flash : code and tables; with the mathematical functions on a bare machine
    ram : static variables
    state, estimate : what a caller holds for each
    stack : a bound, without the compiler's mathematical functions
    """

    target: str
    flash: int
    ram: int
    state: int
    estimate: int
    stack: int


def find_target() -> Target | None:
    """Return a Cortex-M4F where its compiler is found, else this machine; None without any."""
    if arm := shutil.which(f"{ARM}gcc"):
        words = f"Cortex-M4F, {ARM}gcc {_version(arm)} {' '.join(CORTEX_M4F)} -Os"
        return Target(words, (arm, *CORTEX_M4F), f"{ARM}size", f"{ARM}nm", True)
    host = native.compiler()
    if host is None or shutil.which("size") is None or shutil.which("nm") is None:
        return None
    words = f"the machine that exported it, {Path(host).name} {_version(host)} -Os"
    return Target(words, (host,), "size", "nm", False)


def measure(export: Export, target: Target) -> Sizes:
    """Compile an export and return what it takes.

    Raises
    ------
    RuntimeError
        If the compiler rejects it; the message is its own.
    InputError
        If there is no room for what it writes.
    """
    prefix = export.prefix
    probe = filled("probe.c", prefix=prefix, PREFIX=prefix.upper())
    clock = f"-DPEN_MHE_CLOCK={prefix}_seconds"
    flags = [*SMALL, *([clock] if is_timed(export.exported) else [])]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / f"{prefix}.h").write_text(export.header, "utf-8")
        sources = {prefix: export.source, f"{prefix}_model": export.generated, "probe": probe}
        for name, text in sources.items():
            (folder / f"{name}.c").write_text(text, "utf-8")
            _run([*target.command, *flags, "-fstack-usage", "-c", f"{name}.c"], folder)
        objects = [f"{name}.o" for name in sources]
        if target.is_bare:  # linked, so that only what is called counts, with the library
            link = ["-nostartfiles", "-Wl,--gc-sections", "-Wl,-e,main", "--specs=nosys.specs"]
            _run([*target.command, *objects, "-o", "linked.elf", *link, "-lm"], folder)
            measured = ["linked.elf"]
        else:
            measured = [f"{prefix}.o", f"{prefix}_model.o"]
        rows = [line.split() for line in _run([target.size, *measured], folder).splitlines()[1:]]
        code, data, bss = (sum(int(row[column]) for row in rows) for column in range(3))
        held = _held(_run([target.nm, "-S", "probe.o"], folder))
        callers = sum(held.values()) if target.is_bare else 0
        stack = sum(_frames(folder / f"{prefix}.su")) + max(_frames(folder / f"{prefix}_model.su"))
    return Sizes(
        target.words, code + data, data + bss - callers, held["state"], held["estimate"], stack
    )


def size_words(sizes: Sizes | None) -> str:
    """Return what was measured as Markdown."""
    if sizes is None:
        return "Not measured: no C compiler was found."
    rows = {
        "flash: code, tables": sizes.flash,
        "RAM: static": sizes.ram,
        "RAM: a state, the caller's": sizes.state,
        "RAM: an estimate, the caller's": sizes.estimate,
        "stack, at most": sizes.stack,
    }
    lines = [f"| {what} | {bytes_} B |" for what, bytes_ in rows.items()]
    return "\n".join([f"Measured for {sizes.target}:", "", "| | |", "|---|---|", *lines])


def _version(compiler: str) -> str:
    return _run([compiler, "-dumpfullversion"], Path.cwd()).strip()


def _held(symbols: str) -> dict[str, int]:
    """Return the bytes of the probe's variables."""
    found = re.findall(r"^\S+ (\S+) [bBdDC] (state|estimate)$", symbols, re.MULTILINE)
    return {name: int(size, 16) for size, name in found}


def _frames(path: Path) -> list[int]:
    """Return the bytes on the stack of every function of a file."""
    return [int(line.split("\t")[1]) for line in path.read_text("utf-8").splitlines()]


def _run(command: Sequence[str], folder: Path) -> str:
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if result.returncode != 0:
        if reason := lack_of_room(result.stderr):
            raise InputError(f"{folder}: {reason}, expected room to compile what is measured")
        raise RuntimeError(f"{command[0]} failed: {result.stderr.strip()}")
    return result.stdout
