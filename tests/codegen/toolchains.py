"""The compilers that exports are tried with."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from codegen.constant_readings import measured_columns
from codegen.export import Export
from codegen.sizes import ARM, CORTEX_M4F
from estimation import native
from estimation.recording import Measurement

STRICT = (*native.STRICT, "-ffp-contract=off")


@dataclass(frozen=True)
class Toolchain:
    """A compiler with its flags, and its ``nm``."""

    command: tuple[str, ...]
    nm: str


HOST = Toolchain(("gcc",), "nm")
CORTEX = Toolchain((f"{ARM}gcc", *CORTEX_M4F), f"{ARM}nm")
TOOLCHAINS = [
    pytest.param(
        chain,
        id=words,
        marks=pytest.mark.skipif(
            shutil.which(chain.command[0]) is None, reason=f"{chain.command[0]} is not installed"
        ),
    )
    for words, chain in {"host": HOST, "cortex-m4f": CORTEX}.items()
]


def written(export: Export, folder: Path) -> Path:
    """Write an export's three files."""
    for name, text in {
        ".h": export.header,
        ".c": export.source,
        "_model.c": export.generated,
    }.items():
        (folder / f"{export.prefix}{name}").write_text(text, "utf-8")
    return folder


def compile_strictly(
    chain: Toolchain, export: Export, folder: Path, flags: Sequence[str] = ("-Os",)
) -> None:
    """Compile an export as its CMakeLists.txt does; fails with the compiler's words."""
    written(export, folder)
    promotion = ["-Wdouble-promotion"] if export.precision.c_type == "float" else []
    for name in (export.prefix, f"{export.prefix}_model"):
        command = [*chain.command, *STRICT, *promotion, *flags, "-c", f"{name}.c"]
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert result.returncode == 0, f"{' '.join(command)}\n{result.stderr}"


def stream_header(export: Export, measurements: Sequence[Measurement]) -> str:
    """Return C with the times of measurements, and with the readings that a step is given."""
    columns = measured_columns(export.exported.model)
    rows = [f"{{{', '.join(map(_number, m.y[columns]))}}}" for m in measurements]
    times = [float(m.time_s).hex() for m in measurements]
    return "\n".join(
        [
            "#include <math.h>",
            f"#define N_ROWS {len(rows)}",
            f"static const double times[] = {{{', '.join(times)}}};",
            f"static const {export.prefix}_real readings[][{export.prefix.upper()}_N_Y] = {{",
            ",\n".join(rows),
            "};",
        ]
    )


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return float(value).hex()


def symbols(chain: Toolchain, folder: Path, file: str, option: str) -> set[str]:
    """Return the names that ``nm`` tells with an option."""
    command = [chain.nm, option, file]
    told = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    return {line.split()[-1] for line in told.splitlines() if line}
