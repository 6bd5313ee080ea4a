"""Squared distances of many vectors at once, beside NumPy's own solver for each."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.mahalanobis import squared_distances


@pytest.mark.parametrize("m", [1, 2, 5, 13])
def test_each_is_the_solution_of_its_own_system(m: int) -> None:
    rng, n = np.random.default_rng(m), 60
    roots = rng.standard_normal((n, m, m)) + 2 * np.eye(m)
    D = 10.0 ** rng.uniform(-5, 5, m)
    P = D[:, None] * (roots @ roots.transpose(0, 2, 1)) * D
    e, used = D * rng.standard_normal((n, m)), rng.random((n, m)) < 0.7
    found = squared_distances(e, P, used)
    for k in range(n):
        some = used[k]
        if not some.any():
            assert np.isnan(found[k])
            continue
        v, S = e[k, some] / D[some], P[k][np.ix_(some, some)] / np.outer(D[some], D[some])
        assert found[k] == pytest.approx(v @ np.linalg.solve(S, v), rel=1e-8)


def test_one_by_one_they_are_the_same_to_the_last_bit() -> None:
    rng, n, m = np.random.default_rng(0), 30, 12
    roots = rng.standard_normal((n, m, m))
    P, e = roots @ roots.transpose(0, 2, 1), rng.standard_normal((n, m))
    used = rng.random((n, m)) < 0.8
    alone = [squared_distances(e[[k]], P[[k]], used[[k]])[0] for k in range(n)]
    np.testing.assert_array_equal(squared_distances(e, P, used), alone)


def test_what_is_not_used_may_be_anything() -> None:
    P = np.array([[[4.0, np.nan], [np.nan, -1.0]], [[np.nan, 0.0], [0.0, 1.0]]])
    e = np.array([[2.0, np.nan], [np.inf, 3.0]])
    used = np.array([[True, False], [False, True]])
    np.testing.assert_array_equal(squared_distances(e, P, used), [1.0, 9.0])
    np.testing.assert_array_equal(squared_distances(e, P, ~used), [np.inf, np.inf])


def test_of_nothing_there_is_none() -> None:
    empty = squared_distances(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3), dtype=bool))
    assert empty.shape == (0,)
    none = squared_distances(np.zeros((2, 0)), np.zeros((2, 0, 0)), np.zeros((2, 0), dtype=bool))
    np.testing.assert_array_equal(none, [np.nan, np.nan])
