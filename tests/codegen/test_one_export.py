"""Files of two exports do not compile together; those of one do."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from codegen.folder import export_files
from models.pen import pen_model
from models.pen_file import load_pen
from tests.codegen.exports import made
from tests.codegen.toolchains import STRICT
from tests.engines import needs_compiler

SOURCES = ("pen.c", "pen_model.c")


def compile_in(folder: Path, source: str, files: Mapping[str, str]) -> str:
    """Look at a source as a compiler does; return what it says."""
    for name, text in files.items():
        (folder / name).write_text(text, "utf-8")
    command = ["gcc", *STRICT, "-fsyntax-only", source]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True).stderr


@needs_compiler
@pytest.mark.usefixtures("interpreted")
def test_files_of_two_exports_do_not_compile_together(tmp_path: Path) -> None:
    pen = load_pen("reference")
    one, other = (
        export_files(made("ekf", pen_model(pen, [sensor])), None, "")
        for sensor in ("accel", "gyro")
    )
    assert one == export_files(made("ekf", pen_model(pen, ["accel"])), None, "")
    for source in SOURCES:
        assert compile_in(tmp_path, source, one) == ""
        said = compile_in(tmp_path, source, {**one, "pen.h": other["pen.h"]})
        assert "pen.h is of another export than this file: export again" in said
        assert "another export" in compile_in(tmp_path, source, {**one, source: other[source]})
