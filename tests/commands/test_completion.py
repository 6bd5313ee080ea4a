"""What a shell gets that completes a word, by its protocol, and what that costs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache

import pytest

SLOW = ("casadi", "numpy", "scipy", "pandas", "matplotlib")


CODE = f"""
import contextlib, io, json, os, sys
from commands.cli import app
told = []
for line in json.loads(sys.argv[1]):
    whole = line.partition("'")[0]  # behind it is one word, however many spaces it has
    os.environ["COMP_WORDS"], os.environ["COMP_CWORD"] = line, str(whole.count(" "))
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.suppress(SystemExit):
        app(prog_name="pen-mhe")
    found = [word for word in printed.getvalue().splitlines() if word]
    told.append([found, [name for name in {SLOW} if name in sys.modules]])
print(json.dumps(told))
"""


@cache
def completed(*lines: str) -> list[tuple[list[str], list[str]]]:
    """Complete the last words of lines as bash does; and the slow modules imported until then.

    All in one process, one after the other.
    """
    result = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps([f"pen-mhe {line}" for line in lines])],
        env={**os.environ, "_PEN_MHE_COMPLETE": "complete_bash"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.returncode, result.stderr) == (0, "")
    return [(words, imported) for words, imported in json.loads(result.stdout)]


DPOINT = ["accel", "gyro", "camera", "contact", "area"]
MOTIONS = ["turn", "still", "upright", "loops", "yong", "handwriting", "model"]


QUICK: dict[str, list[str]] = {
    "estimate --pen ": ["compass", "dpoint", "reference"],
    "observe --pen r": ["reference"],
    "estimate r.csv --horizon 3 --pen dpoint --sensors ": DPOINT,
    "observe --pen dpoint --sensors accel,c": ["accel,camera", "accel,contact"],
    "observe --pen dpoint --sensors gyro,accel,": [f"gyro,accel,{s}" for s in DPOINT[2:]],
    "estimate --sensors accel_": ["accel_lower", "accel_upper"],
    "simulate --sensors accel_u": ["accel_upper"],
    "observe --pen nowhere --sensors ": [],
    "simulate --motion ": MOTIONS,
    "calibrate still --pen ": ["compass", "dpoint", "reference"],
    "calibrate ": ["still", "magnetometer", "camera"],
    "benchmark pen s": ["speed"],
    "estim": ["estimate"],
}
LONGER: dict[str, list[str]] = {
    "estimate --estimator mhe-r": ["mhe-rti"],
    "estimate --pen dpoint --out": ["--output"],
    "estimate --writing": ["--writing-area"],
    "codegen --estimator ": ["ekf", "mhe-rti"],
    "benchmark consistency --estimators ekf,mhe-s": ["ekf,mhe-sparse"],
    "simulate --stamps a": ["arrival"],
    "benchmark printed-cost consistency --cases 'speed 1,mo": ["speed 1,moving"],
    "benchmark printed-cost --cases 'speed 1,speed": [
        f"speed 1,speed {speed}" for speed in ("0.25", "0.5", "2", "4")
    ],
    "benchmark tilt --cases '\"swing, two": ['"swing, two axes"'],
}


@pytest.mark.parametrize("line", QUICK)
def test_names_are_completed_without_anything_slow(line: str) -> None:
    assert dict(zip(QUICK, completed(*QUICK), strict=True))[line] == (QUICK[line], [])


@pytest.mark.parametrize("line", LONGER)
def test_so_is_what_is_slower_to_find(line: str) -> None:
    words, _ = dict(zip(LONGER, completed(*LONGER), strict=True))[line]
    assert words == LONGER[line]


def test_a_pen_file_of_ones_own_completes_its_sensors(tmp_path: os.PathLike[str]) -> None:
    path = os.path.join(tmp_path, "mine.toml")
    with open(path, "w") as file:
        file.write('name = "mine"\n[sensors.imu_accel]\npreset = "ADXL202"\n')
    assert completed(f"estimate --pen {path} --sensors i")[0][0] == ["imu_accel"]
    with open(path, "w") as file:
        file.write("name = ")
    assert completed(f"estimate --pen {path} --sensors ")[0][0] == []
