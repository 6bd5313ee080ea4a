"""What a shell gets that completes a word, by its protocol, and what that costs."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SLOW = ("casadi", "numpy", "scipy", "pandas", "matplotlib")


def completed(line: str, *, imports: bool = False) -> list[str]:
    """Complete the last word of a line as bash does; with the slow modules that it imported."""
    words = line.split(" ")
    code = "import sys; from commands.cli import app\ntry: app(prog_name='pen-mhe')\nfinally: "
    code += f"print(*[name for name in {SLOW} if name in sys.modules])" if imports else "pass"
    protocol = {
        "_PEN_MHE_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    result = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **protocol},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stderr == ""
    return result.stdout.split()


DPOINT = ["accel", "gyro", "camera", "contact", "area"]
MOTIONS = ["turn", "still", "upright", "loops", "yong", "handwriting", "model"]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("estimate --pen ", ["dpoint", "reference"]),
        ("observe --pen r", ["reference"]),
        ("estimate r.csv --horizon 3 --pen dpoint --sensors ", DPOINT),
        ("observe --pen dpoint --sensors accel,c", ["accel,camera", "accel,contact"]),
        ("observe --pen dpoint --sensors gyro,accel,", [f"gyro,accel,{s}" for s in DPOINT[2:]]),
        ("estimate --sensors accel_", ["accel_lower", "accel_upper"]),
        ("simulate --sensors accel_u", ["accel_upper"]),
        ("observe --pen nowhere --sensors ", []),
        ("simulate --motion ", MOTIONS),
        ("calibrate still --pen ", ["dpoint", "reference"]),
        ("calibrate ", ["still", "camera"]),
        ("benchmark pen s", ["speed"]),
        ("estim", ["estimate"]),
    ],
)
def test_names_are_completed_without_anything_slow(line: str, expected: list[str]) -> None:
    assert completed(f"pen-mhe {line}", imports=True) == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("estimate --estimator mhe-r", ["mhe-rti"]),
        ("estimate --pen dpoint --out", ["--output"]),
        ("estimate --writing", ["--writing-area"]),
        ("codegen --estimator ", ["ekf", "mhe-rti"]),
        ("consistency --cases settled,m", ["settled,moving"]),
        ("consistency --estimators ekf,mhe-s", ["ekf,mhe-sparse"]),
        ("simulate --stamps a", ["arrival"]),
    ],
)
def test_so_is_what_is_slower_to_find(line: str, expected: list[str]) -> None:
    assert completed(f"pen-mhe {line}") == expected


def test_a_pen_file_of_ones_own_completes_its_sensors(tmp_path: os.PathLike[str]) -> None:
    path = os.path.join(tmp_path, "mine.toml")
    with open(path, "w") as file:
        file.write('name = "mine"\n[sensors.imu_accel]\npreset = "ADXL202"\n')
    assert completed(f"pen-mhe estimate --pen {path} --sensors i") == ["imu_accel"]
    with open(path, "w") as file:
        file.write("name = ")
    assert completed(f"pen-mhe estimate --pen {path} --sensors ") == []
