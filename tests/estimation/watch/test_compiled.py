"""The statistics of a watch in C are those in Python, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import estimation.native
from estimation.watch.limits import limits_of
from estimation.watch.statistics import NEVER_CALMER, Calmer, Statistics
from models.arrays import Array
from models.pen import pen_model
from models.state_space import StateSpaceModel
from tests.engines import needs_compiler

pytestmark = needs_compiler
N = 400
CHOICES = (
    ("accel", "gyro", "camera"),
    ("accel_lower", "accel_upper"),
    ("gyro", "camera", "contact"),
)


def both(model: StateSpaceModel, monkeypatch: pytest.MonkeyPatch) -> tuple[Statistics, Statistics]:
    compiled = Statistics(model, limits_of(model))
    with monkeypatch.context() as patch:
        patch.setattr(estimation.native, "compiler", lambda: None)
        return compiled, Statistics(model, limits_of(model))


def stream(model: StateSpaceModel, seed: int) -> tuple[Array, Array, Array, Array]:
    """Return times, readings, innovations and their covariances, with holes, repeats, outliers."""
    rng = np.random.default_rng(seed)
    time_s = 0.01 * np.arange(N) + 0.001 * rng.integers(-12, 2, N)  # some are late
    y = np.round(rng.normal(size=(N, model.n_row)), rng.integers(0, 3))
    factors = rng.normal(size=(N, model.n_r, model.n_r))
    S = factors @ factors.transpose(0, 2, 1) + 0.1 * np.eye(model.n_r)
    v = np.einsum("kij,kj->ki", factors, rng.normal(size=(N, model.n_r))) * 0.4
    v[rng.random(N) < 0.03] *= 30
    row = 0
    for sensor in model.sensors:
        missing = rng.random(N) < 0.4
        v[missing, row : row + sensor.n_r] = np.nan
        row += sensor.n_r
    v[rng.random(v.shape) < 0.05] = np.nan  # a row alone
    return time_s, y, v, S


def taken(statistics: Statistics, rows: Sequence[Array], calmer: Calmer) -> tuple[list[int], Array]:
    """Return how many rows each call took, one row left out behind each, and all memories."""
    memory, at, newest_s = statistics.first(), 0, -np.inf
    counts, memories = list[int](), list[Array]()
    while at < N:
        count = statistics.clean(memory, newest_s, *(each[at:] for each in rows), calmer)
        newest_s = max([newest_s, *rows[0][at : at + count + 1].tolist()])
        counts.append(count)
        memories.append(memory.copy())
        if count == 0:
            for sensor in statistics.sensors:
                statistics.forget(memory, sensor.index)
        at += count + 1
    return counts, np.array(memories)


@pytest.mark.parametrize("sensors", CHOICES)
@pytest.mark.parametrize("calmer", [NEVER_CALMER, Calmer(0.5, 1.0, 0.3)])
def test_to_the_last_bit(
    sensors: tuple[str, ...], calmer: Calmer, monkeypatch: pytest.MonkeyPatch
) -> None:
    pen = "dpoint" if "contact" in sensors else "reference"
    compiled, interpreted = both(pen_model(pen, sensors), monkeypatch)
    seen = list[int]()
    for seed in range(3):
        rows = stream(compiled.model, seed)
        counts, memories = taken(compiled, rows, calmer)
        expected, same = taken(interpreted, rows, calmer)
        assert counts == expected
        np.testing.assert_array_equal(memories, same)
        seen += counts
    assert max(seen) > 10, "a long part in which nothing stands out"
    assert 0 in seen


def test_what_stands_out_ends_it_and_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled, _ = both(pen_model("reference", CHOICES[0]), monkeypatch)
    rng = np.random.default_rng(1)
    model = compiled.model
    time_s, y = 0.01 * np.arange(20), rng.normal(size=(20, model.n_row))
    v, S = 0.1 * rng.normal(size=(20, model.n_r)), np.tile(np.eye(model.n_r), (20, 1, 1))
    whole, part = compiled.first(), compiled.first()
    assert compiled.clean(whole, -np.inf, time_s, y, v, S) == 20
    v[12, 0] = 100.0
    assert compiled.clean(part, -np.inf, time_s, y, v, S) == 12
    again = compiled.first()
    assert compiled.clean(again, -np.inf, time_s[:12], y[:12], v[:12], S[:12]) == 12
    np.testing.assert_array_equal(part, again)
    y[5, :3] = y[4, :3]
    y[6, :3] = y[4, :3]
    count = compiled.clean(compiled.first(), -np.inf, time_s, y, v, S)
    assert count in (5, 6), "an accelerometer that repeats itself twice is stuck"
