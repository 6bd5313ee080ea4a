"""What a history keeps: deviations always, covariances where they are asked for."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.consistency import nees, nis
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.innovations import row_sets
from estimation.recording import Recording
from mhe.config import MheRtiConfig
from mhe.realtime import MheRti
from models.errors import InputError
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate

PEN = load_pen("reference")
SENSORS = ("accel", "gyro")
"""With a writing area: no camera says where the tip is."""
MODEL = pen_model(PEN, SENSORS, rest=False)
ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=3)),
}
BYTES_PER_STEP = 500
"""0.5 GB for a million steps; a covariance alone has 1.8 kB."""


@cache
def recording() -> Recording:
    return simulate(PEN, SENSORS, motion="handwriting", duration_s=0.3, seed=2)


@cache
def history(estimator: str, covariances: bool) -> EstimateHistory:
    return run(ESTIMATORS[estimator](MODEL), recording(), covariances=covariances)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_deviations_are_those_of_the_covariances(name: str) -> None:
    """To the last bit; and so is everything else, kept or not."""
    lean, full = history(name, False), history(name, True)
    np.testing.assert_array_equal(lean.std, np.sqrt(np.diagonal(full.covariance, axis1=1, axis2=2)))
    S = np.sqrt(np.diagonal(full.innovation_covariance, axis1=1, axis2=2))
    present = ~np.isnan(full.innovation)
    np.testing.assert_array_equal(lean.innovation_std[present], S[present])
    assert np.isnan(lean.innovation_std[~present]).all()
    for array in ("time_s", "mean", "innovation", "squared_innovations", "iterations"):
        np.testing.assert_array_equal(getattr(lean, array), getattr(full, array))
    assert lean.status == full.status
    assert lean.covariances is None


@pytest.mark.parametrize("name", ESTIMATORS)
def test_nis_needs_no_covariances(name: str) -> None:
    """Of all rows, of those that measure and of each sensor; other rows do need them."""
    lean, full = history(name, False), history(name, True)
    bare = dataclasses.replace(full, row_sets={})
    sets = row_sets(MODEL)
    assert list(sets) == ["measured", "all", *(sensor.name for sensor in MODEL.sensors)]
    for rows in (None, MODEL.measured_rows, *sets.values()):
        squared, freedom = nis(lean, rows)
        from_covariances, count = nis(bare, rows)
        np.testing.assert_array_equal(freedom, count)
        np.testing.assert_allclose(squared, from_covariances, rtol=1e-9)
        assert (~np.isnan(squared)).any()
    some = np.zeros(MODEL.n_r, dtype=bool)
    some[[0, 4]] = True
    with pytest.raises(InputError, match=r"NIS of rows 0, 4 needs full covariances.*covariances=T"):
        nis(lean, some)
    assert np.isfinite(nis(full, some)[0]).all()
    with pytest.raises(InputError, match=rf"rows have shape \(2,\), expected \({MODEL.n_r},\)"):
        nis(lean, some[:2])


def test_a_set_that_another_one_equals_is_left_out() -> None:
    model = pen_model(PEN, ["gyro"], writing_area=False, rest=False)
    assert list(row_sets(model)) == ["measured"]
    np.testing.assert_array_equal(row_sets(model)["measured"], [True] * 3)


def test_what_is_not_kept_says_how_to_keep_it() -> None:
    lean = history("ekf", False)
    sentence = r"kept standard deviations only.*run\(…, covariances=True\)"
    for name in ("covariance", "innovation_covariance"):
        with pytest.raises(InputError, match=sentence):
            getattr(lean, name)
    truth = recording().truth
    assert truth is not None
    states = truth.states(MODEL.state_names, lean.time_s)
    with pytest.raises(InputError, match=r"NEES of ekf needs full cov.*run\(…, covariances=True\)"):
        nees(MODEL, lean, states)
    assert np.isfinite(nees(MODEL, history("ekf", True), states)).all()


@pytest.mark.parametrize("steps", [1, 7, 1000])
def test_a_stream_is_reduced_as_it_comes(steps: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("estimation.estimator.BATCH_STEPS", steps)
    stream = recording().measurements(MODEL)
    found = run_measurements(Ekf(MODEL), stream, covariances=True)
    for array in ("mean", "covariance", "squared_innovations", "innovation_covariance"):
        np.testing.assert_array_equal(getattr(found, array), getattr(history("ekf", True), array))
    assert found.status == history("ekf", True).status


MEASURED = """
import resource
import numpy as np
from benchmark.bodies import BODIES
from ekf_baseline.ekf import Ekf

def peak_bytes():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

body = BODIES["pen15"]()
model, n = body.model(), {n}
time_s, y = body.record(0.5, 0).stacked(model)
y = np.resize(y, (n, model.n_y))
ekf = Ekf(model)
ekf.batch(ekf.init(), time_s, y[: len(time_s)])
time_s = 0.005 * np.arange(n)
before = peak_bytes()
_, history = ekf.batch(ekf.init(), time_s, y)
assert len(history) == n
print((peak_bytes() - before) / n)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no resource module")
@pytest.mark.parametrize("n", [200_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_a_long_batch_stays_small(n: int) -> None:
    """Peak of a process of its own, per step, over a pen of 15 states and 5 rows."""
    code = MEASURED.replace("{n}", str(n))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout) < BYTES_PER_STEP
