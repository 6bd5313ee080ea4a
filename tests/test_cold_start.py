"""What an import brings along: estimators start without tables, figures and statistics."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
HEAVY = ("pandas", "matplotlib", "scipy.optimize", "scipy.stats", "rich", "pyarrow")


def heavy_modules(code: str) -> list[str]:
    """Return which heavy modules a fresh Python has after some code."""
    script = f"{code}\nimport sys\nprint(*sorted(set({HEAVY!r}) & set(sys.modules)))"
    result = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return result.stdout.split()


def test_heavy_modules_would_be_seen() -> None:
    assert heavy_modules(f"import {', '.join(HEAVY)}") == sorted(HEAVY)


@pytest.mark.parametrize(
    "code",
    [
        "import mhe, mhe.realtime, mhe.reference.ipopt, ekf_baseline.ekf",
        "import models.pen, models.turntable, models.own_models",
        "import pen_mhe.estimators, recordings.simulate_pen",
        "from estimation import consistency, observability",
        "import pen_mhe as pm; pm.simulate, pm.create_estimator, pm.run, pm.observe, pm.Mhe",
    ],
)
def test_estimators_import_nothing_heavy(code: str) -> None:
    assert heavy_modules(code) == []


def test_the_command_line_imports_nothing_heavy() -> None:
    assert heavy_modules("import commands.cli") == []


def test_a_first_estimate_imports_nothing_heavy() -> None:
    code = (
        "import numpy, ekf_baseline.ekf, estimation.native, estimation.recording\n"
        "import models.pen, models.pen_file\n"
        "estimation.native.compiler = lambda: None\n"
        "model = models.pen.pen_model(models.pen_file.load_pen('reference'), ['accel'])\n"
        "ekf = ekf_baseline.ekf.Ekf(model)\n"
        "y = numpy.zeros(model.n_y)\n"
        "ekf.step(ekf.init(), estimation.recording.Measurement(0.0, y))\n"
    )
    assert heavy_modules(code) == []
