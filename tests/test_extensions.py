"""One file and one row: a toy of every kind, added to a copy of the house, appears everywhere.

A sensor kind, a recording format, an estimator and a motion; a suite is a folder and a row.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from tests.house import ROOT, rooms

FILES = {
    "models/sensor_kinds/inclinometer.py": '''
"""How steep the pen stands."""

from __future__ import annotations

from typing import Literal

import casadi as ca
import numpy as np
from pydantic import PositiveFloat

from models.sensor_kinds.mounted import SensorBase
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class Inclinometer(SensorBase):
    """The elevation, rad."""

    kind: Literal["inclinometer"] = "inclinometer"
    std_rad: PositiveFloat

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        return (("elevation", "rad"),)

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        axis_in_world = body.rigid.world_to_body[2, :]
        return SymbolicReading(ca.asin(axis_in_world[2]), np.array([self.std_rad]))
''',
    "recordings/formats/levels.py": '''
"""Elevations in a JSON file."""

from __future__ import annotations

import json
from pathlib import Path
from types import MappingProxyType

import numpy as np

from estimation.recording import Recording
from models.pen_config import PenConfig
from recordings.asked import Asked
from recordings.written import WrittenRecording


def load_levels(path: Path, pen: PenConfig, asked: Asked) -> WrittenRecording:
    time_s, levels = (np.array(column) for column in json.loads(path.read_text("utf-8")))
    readings = MappingProxyType({"level": levels[:, None]})
    return WrittenRecording(Recording(str(path), time_s, readings))
''',
    "ekf_baseline/stoic.py": '''
"""An estimator that learns nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimation.estimate import Estimate
from estimation.estimator import first_state
from estimation.recording import Measurement
from estimation.status import Status
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, kw_only=True)
class StoicConfig:
    """No settings."""


class Stoic:
    name = "stoic"

    def __init__(self, model: StateSpaceModel, config: StoicConfig | None = None) -> None:
        self.model = model

    def init(self, prior: GaussianState | None = None) -> GaussianState:
        return first_state(self.model, prior)

    def step(
        self, state: GaussianState, measurement: Measurement
    ) -> tuple[GaussianState, Estimate]:
        missing = np.full((self.model.n_r, self.model.n_r), np.nan)
        return state, Estimate(
            measurement.time_s, state, Status.SOLVED, missing[:, 0], missing
        )
''',
    "suites/levels/__init__.py": '"""How steep does a pen stand?"""\n',
    "suites/levels/claims.toml": """
[[claim]]
id = "levels-1"
source = "ours"
says = "An inclinometer beats an estimator that learns nothing."
criterion = "RMS error of the elevation, ekf / stoic, at most 0.5"
of = { case = "nod", sensors = "level", estimator = "ekf", quantity = "elevation" }
against = { estimator = "stoic" }
at_most = 0.5
margin = 0.1
""",
    "suites/levels/suite.py": '''
"""The suite ``levels``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Quantity, Task
from estimation.estimator import run as drive
from models.pen import pen_model
from models.pen_file import load_pen
from models.sensor_kinds.inclinometer import Inclinometer
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate

LEVEL = Inclinometer(std_rad=0.01, rate_hz=50.0)


def tasks(scope: Scope) -> list[Task]:
    return [
        Task("levels", "nod", "level", estimator, seed)
        for estimator in ("stoic", "ekf")
        for seed in range(scope.seeds)
    ]


def run(task: Task, scope: Scope) -> Outcome:
    pen = load_pen("reference").model_copy(update={"sensors": {"level": LEVEL}})
    recording = simulate(pen, ["level"], motion=task.case, duration_s=0.6, seed=task.seed)
    model = pen_model(pen)
    history = drive(create_estimator(task.estimator, model), recording)
    truth = recording.truth.states(["elevation_rad"], history.time_s)[:, 0]
    errors = np.degrees(history.column("elevation_rad") - truth)
    quantities = (Quantity.of_errors("elevation", "deg", errors),)
    return Outcome(model.name, quantities, len(errors), 1.0, 1e-6, 1e-6)


SUITE = Suite(
    name="levels",
    title="Levels",
    summary="How steep does a pen stand?",
    tasks=tasks,
    run=run,
    claims=Path(__file__).with_name("claims.toml"),
    figures=lambda results: [],
)
''',
}

ROWS = (
    (
        "models/sensor_kinds/table.py",
        "    Rest,\n)",
        "    Rest,\n    Inclinometer,\n)",
        "from models.sensor_kinds.inclinometer import Inclinometer",
    ),
    (
        "recordings/formats/table.py",
        '    RecordingFormat(".xlsx"',
        '    RecordingFormat(".levels", lambda p: p.suffix == ".levels", read=load_levels),\n'
        '    RecordingFormat(".xlsx"',
        "from recordings.formats.levels import load_levels",
    ),
    (
        "pen_mhe/estimators.py",
        '        "ekf": EstimatorRow(',
        '        "stoic": EstimatorRow(make=Stoic, config=StoicConfig),\n'
        '        "ekf": EstimatorRow(',
        "from ekf_baseline.stoic import Stoic, StoicConfig",
    ),
    (
        "suites/table.py",
        '        "pen": "suites.pen.suite",',
        '        "levels": "suites.levels.suite",\n        "pen": "suites.pen.suite",',
        "",
    ),
    (
        "models/motions.toml",
        "\n[still]\n",
        '\n[nod]\nkind = "minimum_jerk"\ndescription = "a pen that nods"\n'
        "time_s = [0.0, 0.5, 1.0]\ntip_mm = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\n"
        "angles_deg = [[0, 40, 0], [0, 70, 0], [0, 40, 0]]\n\n[still]\n",
        "",
    ),
)
"""File, where its row goes, with the row there, and the import that the row needs."""

PEN = """
name = "pen with a level"
[sensors.level]
kind = "inclinometer"
std_deg = 0.5
rate_hz = 50.0
[sensors.gyro]
preset = "LSM6DS3-gyroscope"
rate_hz = 50.0
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the rooms with all toys, and a pen file that has the sensor."""
    root = tmp_path_factory.mktemp("house")
    shutil.copy(ROOT / "pyproject.toml", root)
    for room in rooms():
        shutil.copytree(
            ROOT / room, root / room, ignore=shutil.ignore_patterns("__pycache__", "*.pyc")
        )
    for name, text in FILES.items():
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_text(text, "utf-8")
    for name, place, row, needed in ROWS:
        text = (root / name).read_text("utf-8")
        assert text.count(place) == 1, f"{name}: {place}"
        text = text.replace(place, row)
        if needed:
            start = "from __future__ import annotations\n"
            text = text.replace(start, f"{start}\n{needed}\n")
        (root / name).write_text(text, "utf-8")
    (root / "level.toml").write_text(PEN, "utf-8")
    return root


def python(house: Path, *arguments: str) -> str:
    """Run Python in the copied house; return what it says."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(house),
        "PEN_MHE_CACHE": str(house / "cache"),
        "COLUMNS": "200",
    }
    result = subprocess.run(
        [sys.executable, *arguments],
        cwd=house,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def pen_mhe(house: Path, *arguments: str) -> str:
    """Run the command in the copied house."""
    return python(house, "-m", "commands.cli", *arguments)


@pytest.fixture(scope="module")
def nod(house: Path) -> Path:
    """A recording of the toy motion by the toy sensor."""
    recording = house / "nod.csv"
    simulate = ("simulate", "--pen", "level.toml", "--motion", "nod", "--duration", "0.4")
    pen_mhe(house, *simulate, "--output", str(recording))
    return recording


def test_a_sensor_kind_and_a_motion_are_simulated(nod: Path) -> None:
    header, *rows = nod.read_text("utf-8").splitlines()
    assert "level_elevation_rad" in header.split(",")
    assert len(rows) > 15


def test_a_sensor_kind_is_observed(house: Path) -> None:
    said = pen_mhe(house, "observe", "--pen", "level.toml", "--duration", "0.3")
    assert "level, gyro" in said
    assert "| elevation_rad |" in said


def test_a_sensor_kind_and_an_estimator_estimate(house: Path, nod: Path) -> None:
    estimate = ("estimate", str(nod), "--pen", "level.toml", "--estimator", "stoic")
    pen_mhe(house, *estimate, "--output", str(house / "out.csv"))
    estimates = pd.read_csv(house / "out.csv")
    assert set(estimates["elevation_rad"]) == {0.9}  # the prior's
    assert len(estimates) == len(nod.read_text("utf-8").splitlines()) - 1


def test_a_format_is_read(house: Path) -> None:
    columns = [[k / 50 for k in range(20)], [0.7] * 20]
    (house / "hand.levels").write_text(json.dumps(columns), "utf-8")
    estimate = ("estimate", "hand.levels", "--pen", "level.toml", "--estimator", "stoic")
    pen_mhe(house, *estimate, "--output", str(house / "levels.csv"))
    assert len((house / "levels.csv").read_text("utf-8").splitlines()) == 21
    said = python(
        house, "-c", "from recordings.formats.table import format_names; print(format_names())"
    )
    names = "a folder of tables, a D-POINT folder, .txt or .tsv, .json, .csv, .parquet, .levels"
    assert said.strip() == f"{names}, .xlsx, .zip or a ROS bag"


def test_a_suite_runs_with_all_of_them(house: Path) -> None:
    run = ("benchmark", "levels", "--seeds", "1", "--jobs", "1", "--output", str(house / "run"))
    said = pen_mhe(house, *run)
    report = (house / "run" / "report.md").read_text("utf-8")
    assert "report.html" in said
    assert "✓ holds | An inclinometer beats an estimator that learns nothing." in report


def test_an_estimator_is_in_the_benchmark(house: Path) -> None:
    """In every suite that runs the estimators; nothing there takes it for another."""
    code = """
from benchmark.tasks.suite import Scope
from suites.execute import execute
from suites.table import find_suite
for name in ("pen", "tilt"):
    assert [t for t in find_suite(name).tasks(Scope(1)) if t.estimator == "stoic"], name
task = next(t for t in find_suite("tilt").tasks(Scope(1)) if t.estimator == "stoic")
outcome = execute(task, Scope(1))
assert outcome.status == "ok", outcome.reason
print([quantity.name for quantity in outcome.quantities])
"""
    said = python(house, "-c", code)
    assert "direction" in said
    assert "operations" not in said
