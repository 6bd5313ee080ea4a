"""Tests whose compiled loops ASan and UBSan watch, in a Python that has their libraries."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.sanitize.exports import SANITISERS

ROOT = Path(__file__).resolve().parents[2]
ALL = (
    "tests/ekf_baseline",
    "tests/mhe",
    "tests/estimation",
    "tests/codegen",
    "tests/test_contracts.py",
)
QUICK = (
    "tests/ekf_baseline/test_compiled_is_interpreted.py",
    "tests/mhe/test_constrained_engines.py",
)
WATCHING = ("--capture=sys", "-p", "no:cacheprovider")
"""What a sanitiser says goes past Python: it is seen when the process ends."""
LIBRARIES = ("libasan.so", "libstdc++.so.6")
"""What must be there before anything else: the second for CasADi, which throws."""
COMPILER = """#!/bin/sh
unset LD_PRELOAD
exec gcc "$@" -O1 {flags}
"""
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0:detect_stack_use_after_return=0",  # Python keeps what it has
    "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    "PYTHONMALLOC": "malloc",  # each array with forbidden ground around it
}


def environment(folder: Path) -> dict[str, str]:
    """Return the environment of a Python whose C is compiled with sanitisers; writes a compiler."""
    folder.mkdir(parents=True, exist_ok=True)
    compiler = folder / "gcc"
    compiler.write_text(COMPILER.format(flags=" ".join(SANITISERS)), "utf-8")
    compiler.chmod(0o755)
    asked = [["gcc", f"-print-file-name={name}"] for name in LIBRARIES]
    found = [subprocess.run(words, capture_output=True, text=True, check=True) for words in asked]
    libraries = [str(Path(each.stdout.strip()).resolve()) for each in found]
    return {
        **os.environ,
        **OPTIONS,
        "CC": str(compiler),
        "LD_PRELOAD": " ".join(libraries),
        "PEN_MHE_CACHE": str(folder / "cache"),
    }


def run(folder: Path, tests: Sequence[str]) -> int:
    """Run tests; return pytest's code, or that of what a sanitiser ended."""
    command = [sys.executable, "-m", "pytest", "-q", "-m", "not slow", *WATCHING]
    return subprocess.run([*command, *tests], cwd=ROOT, env=environment(folder)).returncode
