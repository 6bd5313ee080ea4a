"""From a guess of the held rows to the optimum of a QP."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

from mhe.config import MheConfig
from mhe.interpreted.window_pass import WindowPass
from mhe.sparse_qp.crossover import crossed_over
from mhe.sparse_qp.osqp_window import OsqpWindow
from models.arrays import Array
from tests.mhe.bounded_cases import bounded_case
from tests.mhe.bounded_windows import BoundedKey, bounded_window
from tests.mhe.linearised_windows import linearised, run
from tests.references.least_distance import least_distance

TOLERANCE = 1e-10


def least_distance_qp(seed: int, n: int, rows: int) -> tuple[Array, Array]:
    """G u >= h with a solution, and the origin outside."""
    rng = np.random.default_rng(seed)
    G = rng.standard_normal((rows, n))
    return G, G @ rng.uniform(0.5, 2, n) - rng.uniform(0, 1, rows)


def solve(G: Array, h: Array, guess: NDArray[np.bool_]) -> tuple[Array, Array] | None:
    """The same with its variables twice, the second pair tied to the first by equations."""
    rows, n = G.shape
    P = sp.csc_matrix(sp.diags_array(np.repeat([0.0, 1.0], n)))
    A = sp.csc_matrix(np.block([[np.eye(n), -np.eye(n)], [-G, np.zeros((rows, n))]]))
    upper = np.concatenate([np.zeros(n), -h])
    lower = np.concatenate([np.zeros(n), np.full(rows, -np.inf)])
    held = np.concatenate([np.zeros(n, dtype=bool), guess])
    found = crossed_over(P, A, lower, upper, held, TOLERANCE)
    return None if found is None else (found[0][:n], found[1][n:])


@pytest.mark.parametrize("guess", ["right", "none", "all but some"])
@pytest.mark.parametrize("seed", range(20))
def test_the_optimum_from_any_guess(seed: int, guess: str) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 12))
    G, h = least_distance_qp(seed, n, int(rng.integers(n, 2 * n)))
    u, multipliers = least_distance(G, h)
    wrong = rng.random(len(h)) < 0.2
    guesses = {
        "right": multipliers > 0,
        "none": np.zeros(len(h), dtype=bool),
        "all but some": (multipliers > 0) ^ wrong,
    }
    found = solve(G, h, guesses[guess])
    assert (multipliers > 0).sum() >= 1
    assert found is not None
    assert found[0] == pytest.approx(u, abs=1e-9)
    assert found[1] == pytest.approx(multipliers, abs=1e-8)


def test_the_same_row_twice() -> None:
    """Both may be held, each then takes a part of the multiplier."""
    G, h = np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([1.0, 1.0])
    for guess in ([True, True], [True, False], [False, False]):
        found = solve(G, h, np.array(guess))
        assert found is not None
        assert found[0] == pytest.approx([1.0, 0.0], abs=1e-12)
        assert found[1].sum() == pytest.approx(1.0, abs=1e-12)
        assert (found[1] >= 0).all()


@pytest.mark.parametrize("guess", [True, False])
def test_rows_that_contradict_each_other(guess: bool) -> None:
    G, h = np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, 1.0])
    assert solve(G, h, np.full(2, guess)) is None


def test_a_guess_that_contradicts_itself() -> None:
    """A band: both its sides cannot hold at once, one does."""
    G, h = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]), np.array([1.0, -2.0, 0.5])
    found = solve(G, h, np.array([True, True, False]))
    assert found is not None
    assert found[0] == pytest.approx([1.0, 0.5], abs=1e-12)
    assert found[1] == pytest.approx([1.0, 0.0, 0.5], abs=1e-12)


@pytest.mark.usefixtures("interpreted")
def test_a_pen_between_paper_and_a_ceiling_that_osqp_does_not_polish() -> None:
    """Its height is known to 0.1 m, the shape of its path to micrometres: a stiff band of 2 mm.

    OSQP's own optimum is about 1e-7 off then.
    """
    window = bounded_window(BoundedKey(8, "pen15", "few", 8))
    model = bounded_case("pen15").bounded
    measurements = list(window.measurements)
    given = linearised(model.replace(prior=window.prior), measurements, seed=0, off=0.0)
    given.view.x[:], given.view.w[:] = window.free.states, window.free.noises
    given.d[:] = window.free.states[0] - window.prior.mean
    passes = WindowPass(model, MheConfig(horizon=8))
    wanted = passes.run(given.view, given.d, given.scales)
    found = run(given, OsqpWindow(model, 9))
    std = np.sqrt(np.diag(found.newest))
    assert found.solved
    assert (found.multipliers > 1e3).sum() >= 3
    assert np.abs((found.d - wanted.d) / std).max() < 1e-8
