"""An exported step finds rest as the loop here does, in both precisions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from codegen.header import header
from estimation.estimator import run_measurements
from estimation.recording import Measurement
from pen_mhe.estimators import create_estimator
from tests.engines import needs_compiler
from tests.estimation.resting import model_at_rest
from tests.estimation.test_rest_engines import FOUND, TIME_S, Y, said

MODEL = model_at_rest()
MEASUREMENTS = [Measurement(float(t), y) for t, y in zip(TIME_S, Y, strict=True)]


@needs_compiler
@pytest.mark.parametrize(
    ("name", "settings"),
    [("ekf", {}), pytest.param("mhe-rti", {"horizon": 3}, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize(("real", "tolerance"), [("double", 0.0), ("float", 0.02)])
def test_it_finds_the_same(name: str, settings: Any, real: str, tolerance: float) -> None:
    """Deviations are in standard deviations; single precision's as of any stream."""
    here = run_measurements(create_estimator(name, MODEL, **settings), MEASUREMENTS)
    prefix = f"rest_{name.replace('-', '_')}_{real}"
    export = export_texts(exportable(name, MODEL, **settings), real, prefix=prefix)
    there = run_measurements(Exported(export), MEASUREMENTS)
    assert (said(MODEL, here) == FOUND).all()
    assert (said(MODEL, there) == FOUND).all()
    assert (np.abs(there.mean - here.mean) / here.std).max() <= tolerance


def test_a_caller_gives_no_rest() -> None:
    export = export_texts(exportable("ekf", MODEL))
    assert "#define PEN_N_Y 6 " in export.header
    assert "whether the body rests: still" in export.header
    assert export.header == header(export.exported, "pen", export.precision, export.form)


def test_an_export_without_rest_has_none_of_it() -> None:
    plain = MODEL.replace(sensors=MODEL.sensors[:3])
    assert "#define RESTS 0" in export_texts(exportable("ekf", plain)).source
    assert "rest_told" not in exportable("ekf", plain).loop.memory.shapes
