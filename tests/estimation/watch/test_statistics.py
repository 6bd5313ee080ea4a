"""The running statistics of a watch against sums over all samples, written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from estimation.watch.limits import WINDOWS_S, limits_of
from estimation.watch.statistics import Statistics
from models.arrays import Array
from models.pen import pen_model

N, RATE_HZ = 60, 100.0


def whitened(v: Array, S: Array) -> Array:
    return np.linalg.solve(np.linalg.cholesky(S), v)


def measures(z: Array, a: float) -> tuple[float, float]:
    """Return mean score and e of samples (n, k), the newest last, by their weights."""
    weights = a * (1 - a) ** np.arange(len(z))[::-1]
    mean = weights @ z
    full = np.sum((a * (1 - a) ** np.arange(10_000)) ** 2)
    return float(mean @ mean / full), float(weights @ (z**2).mean(axis=1))


def test_windows_are_weighted_sums() -> None:
    model = pen_model("reference", ["accel", "gyro"])
    statistics, rng = Statistics(model, limits_of(model)), np.random.default_rng(0)
    memory, samples = statistics.first(), list[Array]()
    for _ in range(N):
        factor = rng.normal(size=(model.n_r, model.n_r))
        S, v = factor @ factor.T + np.eye(model.n_r), rng.normal(size=model.n_r)
        z, _ = statistics.distances(v.tolist(), S.tolist())
        statistics.take(memory, z)
        samples.append(np.concatenate([whitened(v[r], S[r, r]) for r in (slice(3), slice(3, 6))]))
        np.testing.assert_allclose(z[:6], samples[-1], rtol=1e-9)
    for i, rows in enumerate((slice(3), slice(3, 6))):
        found = statistics.values(memory)[i]
        for w, tau in enumerate(WINDOWS_S):
            expected = measures(np.array(samples)[:, rows], 1 - np.exp(-1 / (RATE_HZ * tau)))
            assert (found[w], found[len(WINDOWS_S) + w]) == pytest.approx(expected)


def test_an_outlier_is_beyond_its_quantile() -> None:
    model = pen_model("reference", ["gyro"])
    statistics, memory = Statistics(model, limits_of(model)), None
    memory = statistics.first()
    statistics.take(memory, [0.1] * model.n_r)
    for factor, expected in ((0.99, []), (1.01, [0])):
        v = np.full(model.n_r, np.nan)
        v[:3] = [np.sqrt(factor * chi2.ppf(1 - 1e-7, 3)), 0.0, 0.0]
        _, far = statistics.distances(v.tolist(), np.eye(model.n_r).tolist())
        assert statistics.outliers(memory, far) == expected


def test_repeats_in_all_axes_and_of_one() -> None:
    model = pen_model("reference", ["gyro"])
    statistics, rng = Statistics(model, limits_of(model)), np.random.default_rng(1)
    limits = statistics.sensors[0].limits
    memory, found = statistics.first(), list[bool]()
    for k in range(5):
        found.append(bool(statistics.repeats(memory, 0.01 * k, np.array([1.0, 2.0, 3.0]))))
    assert found == [k >= limits.repeats for k in range(5)]
    memory, found = statistics.first(), []
    for k in range(10):
        y = np.array([1.0, *rng.normal(size=2)])
        found.append(bool(statistics.repeats(memory, 0.01 * k, y)))
    assert found == [k >= limits.same for k in range(10)]


def test_nothing_is_said_of_a_sensor_that_reads_a_plane_or_nothing() -> None:
    model = pen_model("dpoint", ["gyro", "contact"])
    limits = dict(zip((s.name for s in model.sensors), limits_of(model), strict=True))
    contact = limits["contact"]
    assert contact is not None
    assert contact.repeats == 0
    assert limits["area"] is None
