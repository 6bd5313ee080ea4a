"""An export's ARM code, run: what it tells is what this machine tells."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from codegen.estimate_fields import estimate_fields, estimate_structure
from codegen.exported import Exported
from estimation.result import result_layout
from tests.codegen.exports import made
from tests.codegen.toolchains import CORTEX, stream_header, written
from tests.disturbed import disturbed
from tests.engines import needs_compiler
from tests.estimation import pens

pytestmark = [
    needs_compiler,
    pytest.mark.skipif(
        shutil.which(CORTEX.command[0]) is None, reason=f"{CORTEX.command[0]} is not installed"
    ),
    pytest.mark.skipif(shutil.which("qemu-arm") is None, reason="qemu-arm is not installed"),
]

PROGRAM = Path(__file__).with_name("arm_program.c")
LINK = ("-nostartfiles", "-Wl,-e,_start", "--specs=nosys.specs")
RUN = pens.draw_pen_run(60, seed=11)
C_TYPES = {"double": ctypes.c_double, "float": ctypes.c_float}
TOLERANCE_STD = {"double": 1e-11, "float": 1e-3}
"""Sines of two C libraries differ in the last bit."""


@pytest.mark.parametrize(
    ("name", "real"),
    [
        ("ekf", "double"),
        ("ekf", "float"),
        pytest.param("mhe-rti", "double", marks=pytest.mark.slow),
        ("mhe-rti", "float"),
    ],
)
def test_the_same_steps(name: str, real: str, tmp_path: Path) -> None:
    export = made(name, RUN.model, real, "root")
    measurements = disturbed(RUN.measurements)
    folder = written(export, tmp_path)
    (folder / "stream.h").write_text(stream_header(export, measurements))
    (folder / "program.c").write_text(PROGRAM.read_text())
    files = ["pen.c", "pen_model.c", "program.c"]
    flags = ["-O1", "-ffp-contract=off", "-std=gnu99", *LINK]
    subprocess.run([*CORTEX.command, *flags, *files, "-o", "arm", "-lm"], cwd=folder, check=True)
    command = ["qemu-arm", "-cpu", "any", str(folder / "arm")]
    told = subprocess.run(command, capture_output=True, check=True, timeout=300).stdout
    structure = estimate_structure(estimate_fields(result_layout(RUN.model)), C_TYPES[real])
    assert len(told) == len(measurements) * ctypes.sizeof(structure)
    on_arm = (structure * len(measurements)).from_buffer_copy(told)
    here, n_x = Exported(export), RUN.model.n_x
    here.init()
    worst = 0.0
    for measurement, arm in zip(measurements, on_arm, strict=True):
        here.take(measurement.time_s, measurement.y)
        blocks = {block: here.layout.view(here.told(), block) for block in here.layout.shapes}
        std = np.sqrt(np.diag(blocks["covariance"]))
        off = np.asarray(RUN.model.difference(np.array(arm.mean), blocks["mean"])).ravel()
        P = np.array(arm.covariance).reshape(n_x, n_x)
        off_P = (P - blocks["covariance"]) / np.outer(std, std)
        worst = max(worst, np.abs(off / std).max(), np.abs(off_P).max())
        assert arm.status == blocks["status"]
        assert arm.time_s == blocks["time_s"]
    assert worst < TOLERANCE_STD[real]
