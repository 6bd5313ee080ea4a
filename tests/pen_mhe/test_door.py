"""The front door: quick, about thirty names, teaches, and says who stands in its way."""

from __future__ import annotations

import contextlib
import inspect
import io
import pydoc
import resource
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import pen_mhe as pm
from tests.test_faces import examples

ROOT = Path(__file__).resolve().parent.parent.parent
MOST_CPU_S = 0.15
REPEATS = 10
ASKED_FOR = {
    *("load_pen", "pen_model", "turntable_model", "own_model", "OwnSensor", "read_recording"),
    *("simulate", "Recording", "Measurement", "run", "estimate", "observe", "create_estimator"),
    "watched",
    *("Ekf", "Mhe", "MheRti", "MheIpopt", "MheConfig", "EkfConfig", "EstimateHistory"),
    *("Status", "InputError", "export_c"),
}


def cpu_s(code: str) -> float:
    """Return the CPU seconds of a fresh Python."""

    def children() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before = children()
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    return children() - before


def test_it_opens_quickly() -> None:
    """Beyond bare Python, in CPU time, so that a busy machine does not count."""
    bare = statistics.median(cpu_s("pass") for _ in range(REPEATS))
    door = statistics.median(cpu_s("import pen_mhe") for _ in range(REPEATS))
    assert door - bare < MOST_CPU_S


def test_it_offers_about_thirty_names() -> None:
    assert set(pm.__all__) >= ASKED_FOR
    assert len(pm.__all__) <= 45


def test_the_version_is_the_projects() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert pm.__version__ == project["version"]


def test_help_teaches() -> None:
    text = pydoc.plain(pydoc.render_doc(pm))
    assert inspect.cleandoc(pm.__doc__ or "").splitlines()[0] in text
    assert "pen = pm.load_pen(" in text
    assert all(name in text for name in pm.__all__)


def test_the_worked_example_works() -> None:
    names: dict[str, Any] = {}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(examples(inspect.cleandoc(pm.__doc__ or "")), names)
    assert {"tip_x_m", "tip_x_m_std", "status"} <= set(names["table"])
    assert len(names["table"]) == len(names["recording"].time_s)
    errors = names["compared"].table
    assert list(errors.index) == ["ekf", "mhe"]
    assert ((errors["tip_mm_rms"] > 0) & (errors["tip_mm_rms"] < 5)).all()
    assert ((errors["elevation_deg_rms"] > 0) & (errors["elevation_deg_rms"] < 5)).all()
    assert "elevation_deg_rms" in printed.getvalue()


@pytest.mark.slow
def test_type_checkers_see_what_stands_behind_it(tmp_path: Path) -> None:
    pytest.importorskip("mypy", reason="the extra [lint] is not installed")
    script = tmp_path / "user.py"
    script.write_text(
        "import pen_mhe as pm\nfrom mhe import Mhe\n"
        "reveal_type(pm.load_pen('reference'))\n"
        "reveal_type(Mhe)\n"
        "pm.load_pen(3)\n"
        "pm.find_pen\n"
    )
    command = [sys.executable, "-m", "mypy", str(script)]
    found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
    assert '"models.pen_config.PenConfig"' in found
    assert "def (model: models.state_space.StateSpaceModel" in found
    assert 'incompatible type "int"; expected "str | Path"' in found
    assert 'has no attribute "find_pen"' in found
    assert "Found 2 errors" in found


def opened(folder: Path, code: str = "import pen_mhe; pen_mhe.Status") -> tuple[int, str]:
    """Return exit code and last line of errors of a Python that was started in a folder."""
    result = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(ROOT)},
    )
    return result.returncode, (result.stderr.splitlines() or [""])[-1]


@pytest.mark.parametrize("file", ["models.py", "mhe.py", "estimation/__init__.py"])
def test_who_shadows_a_room_is_named(file: str, tmp_path: Path) -> None:
    path = tmp_path / file
    path.parent.mkdir(exist_ok=True)
    path.write_text("answer = 42\n")
    room, whole = Path(file).parts[0].removesuffix(".py"), tmp_path / Path(file).parts[0]
    code, error = opened(tmp_path)
    assert code == 1
    assert error == (
        f"ImportError: pen_mhe needs its own package {room} in {ROOT}, but Python finds {whole} "
        f"first, expected no other {room} on the path: rename that one, or work in another folder"
    )


def test_who_shadowed_a_room_before_is_named(tmp_path: Path) -> None:
    (tmp_path / "models.py").write_text("")
    script = "import models, os, sys; os.chdir('/'); sys.path.remove(''); import pen_mhe"
    code, error = opened(tmp_path, script)
    assert code == 1
    assert f"but Python finds {tmp_path / 'models.py'} first" in error


def test_what_does_not_shadow_a_room_is_no_matter(tmp_path: Path) -> None:
    """A folder without __init__.py comes after every package, wherever it is."""
    (tmp_path / "models").mkdir()
    (tmp_path / "mine.py").write_text("")
    assert opened(tmp_path) == (0, "")
