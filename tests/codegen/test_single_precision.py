"""Single precision against double: on the real recording, and over a million samples."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from models.arrays import Array
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.formats.dpoint import load_dpoint
from tests.codegen.streams import compare
from tests.engines import needs_compiler

pytestmark = needs_compiler

DPOINT = load_pen("dpoint")
SENSORS = ("accel", "gyro", "camera")
ESTIMATORS = ("ekf", "mhe-rti")


def pair(name: str, model: StateSpaceModel) -> tuple[Exported, Exported]:
    """Return an estimator in single and in double precision, with its usual settings."""
    single, double = (
        Exported(export_texts(exportable(name, model), r)) for r in ("float", "double")
    )
    return single, double


@pytest.mark.slow
@pytest.mark.parametrize("name", ESTIMATORS)
def test_on_the_real_recording(name: str, dpoint_folder: Path) -> None:
    """A tip at 0.2 m resolves 15 nm in single precision, of a standard deviation of 0.1 mm.

    The gyroscope's bias moves by 40 deviations in the first seconds, with gains that single
    precision knows to 1e-5, and walks so little that it stays where they put it: for biases only
    the limit of every step holds.
    """
    model = pen_model(DPOINT, SENSORS)
    recording = load_dpoint(dpoint_folder, DPOINT).recording.select(SENSORS)
    stream = list(zip(*recording.stacked(model), strict=True))
    assert len(stream) > 5000
    seen = compare(*pair(name, model), stream)
    assert max(seen.mean) < 2e-3
    assert np.median(seen.but_biases) < 4e-4
    assert seen.std < 1e-4
    assert seen.std_parted < 1e-3
    assert seen.eigenvalue > 0
    assert seen.statuses == 0


def at_rest(model: StateSpaceModel, n: int) -> Iterator[tuple[float, Array]]:
    """100 Hz of noisy readings of the prior's mean, the camera at every third sample."""
    rng = np.random.default_rng(0)
    h = np.concatenate([np.asarray(s.h(model.prior.mean)).ravel() for s in model.sensors])
    for k in range(n):
        y = h + model.noise_std * rng.standard_normal(len(h))
        if k % 3:
            y[6:] = np.nan
        yield k / 100, y


@pytest.mark.slow
@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_million_samples(name: str) -> None:
    """Positive definite to the end, and no further from double than in the first hour.

    Now and then a stage is so near the threshold that one precision keeps its factors and the other
    does not. A point that is half a standard deviation away changes what is claimed by more than
    rounding does.
    """
    model = pen_model(DPOINT, SENSORS)
    seen = compare(*pair(name, model), at_rest(model, 1_000_000), every=97)
    assert seen.eigenvalue > 0
    assert seen.statuses == 0
    assert max(seen.mean) < 5e-3
    assert seen.std < 2e-4
    assert seen.std_parted < 2e-3
    assert seen.parted < 1e-3 * 1_000_000
    hour = len(seen.mean) * 36 // 100
    assert np.median(seen.mean[-hour:]) < 2 * np.median(seen.mean[:hour])
