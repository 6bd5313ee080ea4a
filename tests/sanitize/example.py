"""The example program of an export under ASan and UBSan, with recordings that are spoilt."""

from __future__ import annotations

import random
import subprocess
from collections.abc import Iterator
from pathlib import Path

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.folder import export_files
from estimation.native import STRICT
from models.pen import pen_model
from models.pen_file import load_pen
from tests.fuzz.mutators import mutated
from tests.fuzz.seeds import seeds
from tests.sanitize.exports import HOSTED, SANITISERS

LINES = (
    b"",
    b"\n",
    b"time_s",
    b"time_s\n" * 3,
    b",,,\n,",
    b"time_s,accel_x\x00\n0,1\n",
    b"9" * 70_000,
)
"""Files that are none: empty, cut short, with a zero byte, with a line that is too long."""


def spoilt(files: int) -> Iterator[bytes]:
    """Yield a recording as it is, `LINES`, wide and long ones, and so many changed ones."""
    [good] = seeds("csv")[:1]
    header, _, rows = good.partition(b"\n")
    yield good
    yield from LINES
    yield header + b",x" * 2000 + b"\n" + rows
    yield header + b"\n" + rows.replace(b"\n", b"," * 66_000 + b"\n", 1)
    yield good.replace(b"\n", b"\r\n").rstrip()
    draw = random.Random(20)
    for _ in range(files):
        yield mutated(good, draw)


def run(folder: Path, files: int) -> str:
    """Compile the example with sanitisers, run it on files; return what went wrong, or ``""``."""
    model = pen_model(load_pen("reference"), ["accel", "gyro"])
    for name, text in export_files(export_texts(exportable("ekf", model)), None, "").items():
        (folder / name).write_text(text, "utf-8")
    files_of_c = ("main.c", "pen.c", "pen_model.c", "-o", "main", "-lm")
    command = ["gcc", *STRICT, *HOSTED, *SANITISERS, *files_of_c]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if built.returncode:
        return built.stderr
    for number, data in enumerate(spoilt(files)):
        (folder / "in.csv").write_bytes(data)
        told = subprocess.run(["./main", "in.csv", "out.csv"], cwd=folder, capture_output=True)
        said = told.stderr.decode("utf-8", "replace")
        if (told.returncode, said.count("\n")) not in ((0, 0), (1, 1)):
            return f"file {number}: code {told.returncode}, {said}"
    return ""
