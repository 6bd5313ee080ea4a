"""The wheel works outside the checkout, with nothing of the checkout on the path."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.house import ROOT, rooms

SCRIPT = f"""
import sys
ROOMS = {rooms()}
sys.path.insert(0, sys.argv[1])
sys.argv = ["pen-mhe", *sys.argv[2:]]
import importlib
for room in ROOMS:
    assert importlib.import_module(room).__file__.startswith(sys.path[0]), room
from commands.cli import app
app()
"""


def test_the_wheel_the_archive_and_the_types_have_every_room() -> None:
    """The project file names the rooms three times, as its tools want it."""
    tool = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]
    targets = tool["hatch"]["build"]["targets"]
    archived = {name.removeprefix("/") for name in targets["sdist"]["include"]}
    assert set(targets["wheel"]["packages"]) == set(rooms())
    assert set(tool["mypy"]["packages"]) == set(rooms())
    assert {name for name in archived if (ROOT / name).is_dir()} == {*rooms(), "tests"}


@pytest.mark.slow  # .ci/run runs it by itself
def test_the_wheel_works_elsewhere(tmp_path: Path) -> None:
    built, site = tmp_path / "dist", tmp_path / "site"
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(built), str(ROOT)],
        check=True,
    )
    (wheel,) = built.glob("pen_mhe-*.whl")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-compile"]
    subprocess.run([*pip, "--target", str(site), str(wheel)], check=True)
    for room in rooms():
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
