"""The nearest ink by look-up, against a search through all ink."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from estimation.estimate import EstimateHistory
from recordings.ink import OFF_PAPER, TRIMMED_SAMPLES, Ink, ink_match, match_ink
from recordings.ink_map import CELL_MM, MARGIN_MM, InkMap
from tests.benchmark.hand_made import history

HALF_DIAGONAL_MM = CELL_MM / math.sqrt(2)


def scribble(rng: np.random.Generator, n: int = 400) -> np.ndarray:
    """Ink (n, 2) in mm: strokes, and a few dots."""
    walk = np.cumsum(rng.normal(0, 0.3, (n, 2)), axis=0)
    return np.vstack([walk, rng.uniform(-30, 30, (20, 2))])


@pytest.mark.parametrize("seed", range(5))
def test_it_is_nearly_the_nearest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ink = scribble(rng)
    low, high = ink.min(axis=0) - MARGIN_MM, ink.max(axis=0) + MARGIN_MM
    points = rng.uniform(low, high, (5000, 2))
    found, tree = InkMap(ink).nearest(points), cKDTree(ink)
    # What is returned is the middle of a cell with ink in it.
    assert tree.query(found)[0].max() <= HALF_DIAGONAL_MM * (1 + 1e-9)
    # Point, nearest ink and returned ink: each within half a diagonal of its cell's middle.
    surplus = np.linalg.norm(found - points, axis=1) - tree.query(points)[0]
    assert surplus.min() >= -HALF_DIAGONAL_MM * (1 + 1e-9)
    assert surplus.max() <= 3 * HALF_DIAGONAL_MM * (1 + 1e-9)
    assert np.sqrt(np.mean(surplus**2)) < CELL_MM / 2
    assert abs(surplus.mean()) < CELL_MM / 10


def test_a_single_dot_is_the_nearest_from_everywhere() -> None:
    dot = np.array([[3.0, -7.0]])
    points = np.random.default_rng(0).uniform(-500, 500, (1000, 2))
    found = InkMap(dot).nearest(np.vstack([points, dot]))
    assert len(np.unique(found, axis=0)) == 1
    assert np.abs(found[0] - dot).max() <= CELL_MM / 2 + 1e-9


def test_beyond_the_margin_it_is_the_nearest_to_the_edge() -> None:
    ink = np.array([[0.0, 0.0], [0.0, 10.0]])
    beyond = np.array([[-1e6, 10.0], [1e6, 0.0], [0.0, 1e6], [0.0, -1e6]])
    found = InkMap(ink).nearest(beyond)
    assert np.abs(found - ink[[1, 0, 1, 0]]).max() <= CELL_MM


def tip(path_mm: np.ndarray) -> EstimateHistory:
    return history(("tip_x_m", "tip_y_m"), np.arange(len(path_mm)) / 100, 1e-3 * path_mm)


def test_a_path_that_leaves_the_paper_is_infinitely_far() -> None:
    """Decided by its extent: three times the ink's is no writing, a little less is."""
    n = 400
    ink = np.column_stack([np.linspace(0, 40, 2000), np.zeros(2000)])
    pressed = Ink(ink, np.arange(n) / 100, np.ones(n))
    inner = np.zeros((n, 2))
    inner[TRIMMED_SAMPLES:-TRIMMED_SAMPLES, 0] = np.linspace(0, 1, n - 2 * TRIMMED_SAMPLES)
    inner[-TRIMMED_SAMPLES:, 0] = 1.0
    for factor, off in ((OFF_PAPER * 1.01, True), (OFF_PAPER * 0.99, False), (1.0, False)):
        match = ink_match(tip(40 * factor * inner), pressed)
        assert match is not None
        assert math.isinf(match.mean_distance_mm) == off
    assert match.mean_distance_mm < 0.02
    huge = ink_match(tip(1e12 * inner), pressed)
    assert huge is not None
    assert huge.mean_distance_mm == math.inf


def test_too_short_a_path_has_no_distance() -> None:
    ink = Ink(np.zeros((3, 2)), np.arange(3.0), np.ones(3))
    assert ink_match(tip(np.zeros((2 * TRIMMED_SAMPLES + 1, 2))), ink) is None


def test_the_look_up_decides_no_distance() -> None:
    """It finds the place; the distance there is that of a search through all ink."""
    rng = np.random.default_rng(1)
    ink = scribble(rng)
    path = ink[50:350:3] + rng.normal(0, 0.1, (100, 2))
    match = match_ink(path + np.array([120.0, -40.0]), InkMap(ink))
    assert match.mean_distance_mm == cKDTree(ink).query(match.path_mm)[0].mean()
    assert np.abs(match.path_mm - path).max() < 0.1


@pytest.mark.parametrize("seed", range(4))
def test_the_distance_is_that_of_a_settled_shift(seed: int) -> None:
    """Wherever the search began: another round of nearest neighbour and mean changes nothing."""
    rng = np.random.default_rng(seed)
    ink = scribble(rng)
    path = ink[20:380:2] + rng.normal(0, 0.6, (180, 2))
    match = match_ink(path, InkMap(ink))
    nearest = ink[cKDTree(ink).query(match.path_mm)[1]]
    assert np.abs((nearest - match.path_mm).mean(axis=0)).max() < 1e-6
