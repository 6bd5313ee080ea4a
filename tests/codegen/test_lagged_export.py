"""A fixed lag out of an export: in double precision every bit, in single its digits."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from codegen.folder import export_files
from estimation.recording import Measurement
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from tests.codegen.exports import exported, history, made
from tests.codegen.toolchains import HOST, compile_strictly
from tests.engines import needs_compiler
from tests.mhe import pendulum

LAGS = (2, 3, 6)
SETTINGS = {"horizon": 6, "lag_samples": LAGS}
SENSORS = ("accel", "gyro", "camera")
PENDULUM = pendulum.model()


@cache
def stream(which: str) -> tuple[StateSpaceModel, list[Measurement]]:
    """A pendulum; a pen with outputs that are derived and a camera that is late."""
    if which == "pendulum":
        return PENDULUM, pendulum.simulate(40, seed=3)
    model = pen_model(load_pen("reference"), SENSORS)
    recording = simulate(load_pen("reference"), SENSORS, motion="handwriting", duration_s=0.6)
    return model, list(recording.measurements(model, causal=True))


@needs_compiler
@pytest.mark.parametrize("which", ["pendulum", "pen"])
def test_it_is_what_runs_here_to_the_last_bit(which: str) -> None:
    model, measurements = stream(which)
    ours = history(exported("mhe-rti", model, settings=SETTINGS), measurements)
    times, rows = (np.array([getattr(m, name) for m in measurements]) for name in ("time_s", "y"))
    here = create_estimator("mhe-rti", model, **SETTINGS)
    _, wanted = here.batch(here.init(), times, rows, covariances=True)
    for lag in LAGS:
        for a, b in zip(ours.lagged[lag].arrays(), wanted.lagged[lag].arrays(), strict=True):
            np.testing.assert_array_equal(a, b)
        assert np.isfinite(ours.at_lag(lag).std).all()
        assert np.isfinite(ours.at_lag(lag).derived_std).all()
        assert len(ours.at_lag(lag)) >= len(measurements) - lag - 1
    np.testing.assert_array_equal(ours.mean, wanted.mean)


@pytest.mark.cover
@needs_compiler
@pytest.mark.parametrize("form", ["root", "covariance"])
@pytest.mark.parametrize("later_s", [0.0, 36_000.0])
def test_in_single_precision(form: str, later_s: float) -> None:
    """Times far from zero keep their digits; deviations have those of a difference."""
    model, measurements = stream("pen")
    moved = [Measurement(m.time_s + later_s, m.y) for m in measurements]
    single, double = (
        history(exported("mhe-rti", model, real, settings=SETTINGS, form=of), moved)
        for real, of in (("float", form), ("double", None))
    )
    for lag in LAGS:
        a, b = (each.lagged[lag].changed(lambda array: array[20:]) for each in (single, double))
        assert np.abs(a.time_s - b.time_s).max() < 1e-7
        off = np.asarray(model.difference(a.mean.T, b.mean.T)).T / b.std
        assert np.abs(off).max() < 1e-3
        assert np.abs(a.std / b.std - 1).max() < 1e-4
        assert np.abs(a.derived_std / b.derived_std - 1).max() < 1e-4


@needs_compiler
@pytest.mark.parametrize("form", ["covariance", "root"])
def test_strict_compilers_take_it(form: str, tmp_path: Path) -> None:
    compile_strictly(HOST, made("mhe-rti", PENDULUM, "float", form, SETTINGS), tmp_path)


def test_header_and_readme_say_where_a_lag_stands() -> None:
    export = made("mhe-rti", PENDULUM, settings=SETTINGS)
    assert f"#define PEN_N_LAGS {len(LAGS)} " in export.header
    for i, lag in enumerate(LAGS):
        assert f"PEN_LAG_{lag} = {i}, /* samples */" in export.header
    assert re.search(r"double lagged_time\[PEN_N_LAGS\]; /\* .+ \*/", export.header)
    assert "pen_real lagged_mean[PEN_N_LAGS * PEN_N_X]; " in export.header
    assert "pen_real lagged_covariance[PEN_N_LAGS * PEN_N_X * PEN_N_X]; " in export.header
    readme = export_files(export, None, "…")["README.md"]
    assert "estimate.lagged_mean[PEN_LAG_2 * PEN_N_X + PEN_STATE_" in readme
    without = export_files(made("mhe-rti", PENDULUM), None, "…")
    assert not any(re.search(r"lagged|_LAG", without[name]) for name in ("pen.h", "README.md"))
