"""The statistics of a watch in C are those in Python, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import estimation.native
from estimation.watch.asked import NEVER_CALMER, Calmer, Known
from estimation.watch.limits import limits_of
from estimation.watch.quiet import Quiet
from estimation.watch.statistics import Statistics
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


def both(
    model: StateSpaceModel, monkeypatch: pytest.MonkeyPatch
) -> tuple[Statistics, Quiet, Quiet]:
    statistics = Statistics(model, limits_of(model))
    compiled = Quiet(statistics)
    with monkeypatch.context() as patch:
        patch.setattr(estimation.native, "compiler", lambda: None)
        return statistics, compiled, Quiet(statistics)


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


def taken(
    statistics: Statistics, quiet: Quiet, rows: Sequence[Array], calmer: Calmer
) -> tuple[list[int], Array]:
    """Return how many rows each call took, one row left out behind each, and all memories."""
    memory, at, newest_s = statistics.first(), 0, -np.inf
    counts, memories = list[int](), list[Array]()
    while at < N:
        count = quiet.clean(memory, *(each[at:] for each in rows), newest_s=newest_s, calmer=calmer)
        newest_s = max([newest_s, *rows[0][at : at + count + 1].tolist()])
        counts.append(count)
        memories.append(memory.copy())
        if count == 0:
            for sensor in statistics.sensors:
                statistics.forget(memory, sensor.index)
        at += count + 1
    return counts, np.array(memories)


@pytest.mark.cover
@pytest.mark.parametrize("sensors", CHOICES)
@pytest.mark.parametrize("calmer", [NEVER_CALMER, Calmer(0.5, 1.0, 0.3)])
def test_to_the_last_bit(
    sensors: tuple[str, ...], calmer: Calmer, monkeypatch: pytest.MonkeyPatch
) -> None:
    pen = "dpoint" if "contact" in sensors else "reference"
    statistics, compiled, interpreted = both(pen_model(pen, sensors), monkeypatch)
    seen = list[int]()
    for seed in range(3):
        rows = stream(statistics.model, seed)
        counts, memories = taken(statistics, compiled, rows, calmer)
        expected, same = taken(statistics, interpreted, rows, calmer)
        assert counts == expected
        np.testing.assert_array_equal(memories, same)
        seen += counts
    assert max(seen) > 10, "a long part in which nothing stands out"
    assert 0 in seen


def test_what_stands_out_ends_it_and_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    statistics, compiled, _ = both(pen_model("reference", CHOICES[0]), monkeypatch)
    rng = np.random.default_rng(1)
    model = statistics.model
    time_s, y = 0.01 * np.arange(20), rng.normal(size=(20, model.n_row))
    v, S = 0.1 * rng.normal(size=(20, model.n_r)), np.tile(np.eye(model.n_r), (20, 1, 1))
    whole, part = statistics.first(), statistics.first()
    assert compiled.clean(whole, time_s, y, v, S, newest_s=-np.inf) == 20
    v[12, 0] = 100.0
    assert compiled.clean(part, time_s, y, v, S, newest_s=-np.inf) == 12
    again = statistics.first()
    assert compiled.clean(again, time_s[:12], y[:12], v[:12], S[:12], newest_s=-np.inf) == 12
    np.testing.assert_array_equal(part, again)
    y[5, :3] = y[4, :3]
    y[6, :3] = y[4, :3]
    count = compiled.clean(statistics.first(), time_s, y, v, S, newest_s=-np.inf)
    assert count in (5, 6), "an accelerometer that repeats itself twice is stuck"


def test_a_replay_takes_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """In C and in Python, whatever stands out; rows of a history are far apart."""
    statistics, compiled, interpreted = both(pen_model("reference", CHOICES[0]), monkeypatch)
    _, _, v, S = stream(statistics.model, 6)
    spread = np.full((N, statistics.model.n_r * (statistics.model.n_r + 1)), np.nan)
    apart = spread[:, : v.shape[1]], spread[:, v.shape[1] :].reshape(S.shape)
    apart[0][:], apart[1][:] = v, S
    rng = np.random.default_rng(7)
    for first in (0, N - 10, N):
        counts, judged = np.arange(N) >= first, rng.random(statistics.n_sensors) < 0.7
        found, expected = statistics.first(), statistics.first()
        score = compiled.again(found, *apart, counts=counts, judged=judged, fewest=3)
        same = interpreted.again(expected, v, S, counts=counts, judged=judged, fewest=3)
        assert score == same
        assert (score > 0) == (first < N and judged[:3].any())
        np.testing.assert_array_equal(found, expected)


def test_one_instant_is_a_chunk_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """In C and in Python; what is known, or not any more, is looked at first."""
    statistics, compiled, interpreted = both(pen_model("reference", CHOICES[0]), monkeypatch)
    n_x, rng = statistics.model.n_x, np.random.default_rng(4)
    limit = np.where(np.arange(n_x) % 3 == 0, 1.0, np.nan)
    time_s, y, v, S = stream(statistics.model, 5)
    in_c, in_python, quiet = statistics.first(), statistics.first(), 0
    for k in range(N):
        std = rng.uniform(0.1, 0.9, n_x) + (rng.random(n_x) < 0.01)
        known = Known(limit, std < 1.0, rng.uniform(0.1, 0.9, n_x), np.diag(std**2))
        if k % 7 == 0:
            known = known._replace(known=rng.random(n_x) < 0.5)
        row = time_s[k], y[k], v[k], S[k]
        found = compiled.one(in_c, *row, calmer=NEVER_CALMER, known=known)
        expected = interpreted.one(in_python, *row, calmer=NEVER_CALMER, known=known)
        assert (found is None) == (expected is None)
        if found is None or expected is None:
            continue
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(one, other)
        chunk = in_c.copy()
        rows = (each[k : k + 1] for each in (time_s, y, v, S))
        assert compiled.clean(chunk, *rows, newest_s=-np.inf)
        np.testing.assert_array_equal(chunk, found[0])
        (in_c, _), (in_python, _), quiet = found, expected, quiet + 1
    assert N / 4 < quiet < N
