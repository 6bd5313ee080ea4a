"""The dual active set against all subsets of rows, tried one by one."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from estimation.status import Status
from mhe.interpreted.active_set import ActiveSet, Held
from models.arrays import Array


def tried(M: Array, r: Array) -> Array:
    """The multipliers ν ≥ 0 with r - M ν ≤ 0 and ν (r - M ν) = 0, by trying every set."""
    n = len(r)
    for size in range(n + 1):
        for rows in itertools.combinations(range(n), size):
            nu, held = np.zeros(n), list(rows)
            nu[held] = np.linalg.solve(M[np.ix_(held, held)], r[held])
            if (nu >= -1e-12).all() and (r - M @ nu <= 1e-9).all():
                return nu
    raise AssertionError("no set of rows meets the conditions")


def found(M: Array, r: Array, active: list[int] | None = None, capacity: int = 99) -> Held:
    marks = np.zeros(len(r), dtype=bool)
    marks[active or []] = True
    return ActiveSet(r, np.sqrt(np.diag(M)), lambda row: M[:, row], capacity).find(marks)


def drawn(seed: int, n: int = 7) -> tuple[Array, Array]:
    """Rows of different lengths, some nearly parallel."""
    rng = np.random.default_rng(seed)
    C = rng.standard_normal((n, 9)) * 10 ** rng.uniform(-3, 3, (n, 1))
    C[1] = C[0] + 1e-3 * np.linalg.norm(C[0]) * rng.standard_normal(9)
    return C @ C.T, rng.standard_normal(n) * np.linalg.norm(C, axis=1)


@pytest.mark.parametrize("seed", range(40))
def test_multipliers_are_those_of_the_best_set(seed: int) -> None:
    M, r = drawn(seed)
    wanted, rng = tried(M, r), np.random.default_rng(seed)
    starts = [[], list(range(7)), list(rng.permutation(7)[:3])]
    for start in starts:
        held = found(M, r, start)
        scale = np.abs(wanted).max(initial=1e-300)
        assert held.status is Status.SOLVED
        assert np.abs(held.multipliers - wanted).max() <= 1e-6 * scale
        np.testing.assert_array_equal(held.active, held.multipliers > 0)


def test_the_draws_have_none_few_and_many_rows_active() -> None:
    counts = {int((tried(*drawn(seed)) > 0).sum()) for seed in range(40)}
    assert len(counts) >= 4


def test_nothing_exceeded_needs_no_response() -> None:
    def respond(row: int) -> Array:
        raise AssertionError(row)

    held = ActiveSet(np.array([-1.0, 0.0]), np.ones(2), respond, 9).find(np.zeros(2, bool))
    assert held.status is Status.SOLVED
    assert not held.active.any()


def test_the_same_row_twice_is_held_once() -> None:
    M = np.array([[4.0, 4.0], [4.0, 4.0]])
    held = found(M, np.array([2.0, 2.0]))
    assert held.status is Status.SOLVED
    assert held.multipliers.sum() == pytest.approx(0.5)
    assert held.active.sum() == 1


def test_rows_against_each_other_are_infeasible() -> None:
    """x ≤ -1 and x ≥ 1."""
    held = found(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([1.0, 1.0]))
    assert held.status is Status.INFEASIBLE


def test_a_row_that_nothing_moves_is_left_alone() -> None:
    held = found(np.diag([0.0, 1.0]), np.array([1.0, 0.5]))
    assert held.status is Status.SOLVED
    np.testing.assert_allclose(held.multipliers, [0.0, 0.5])


def test_rows_that_are_not_demanded_are_never_held() -> None:
    M, r = drawn(3)
    r[2] = -np.inf
    held = found(M, r, start := [2, 4])
    assert 2 in start
    assert not held.active[2]


def test_more_rows_than_there_is_room_for_is_told() -> None:
    held = found(np.eye(5), np.ones(5), capacity=3)
    assert held.status is Status.SOLVER_FAILED
    assert held.active.sum() == 3
