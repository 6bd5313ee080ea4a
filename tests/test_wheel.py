"""The wheel works outside the checkout, with nothing of the checkout on the path."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
sys.argv = ["pen-mhe", *sys.argv[2:]]
import models, estimation, ekf_baseline, classical_baseline, mhe, codegen, benchmark, pen_mhe
assert all(m.__file__.startswith(sys.path[0]) for m in (models, mhe, pen_mhe)), models.__file__
from commands.cli import app
app()
"""


def test_the_wheel_works_elsewhere(tmp_path: Path) -> None:
    built, site = tmp_path / "dist", tmp_path / "site"
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(built), str(ROOT)],
        check=True,
    )
    (wheel,) = built.glob("pen_mhe-*.whl")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--target", str(site), str(wheel)], check=True)
    for room in (
        *("models", "estimation", "ekf_baseline", "classical_baseline"),
        *("mhe", "codegen", "benchmark", "pen_mhe"),
    ):
        assert (site / room / "py.typed").is_file()
    call = [sys.executable, "-I", "-c", SCRIPT, str(site)]
    recording = tmp_path / "pen.csv"
    simulate = ["simulate", "--output", str(recording), "--duration", "0.3", "--sensors", "accel"]
    estimate = ["estimate", str(recording), "--pen", "reference"]
    estimate += ["--output", str(tmp_path / "out.csv"), "--sensors", "accel,area"]
    for arguments in (simulate, estimate):
        result = subprocess.run(
            [*call, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert result.returncode == 0, result.stderr
    assert (tmp_path / "out.csv").is_file()
