"""E7: the mirror solution, which no inertial sensor sees."""

from __future__ import annotations

import numpy as np
import pytest

from models.turntable import mirror, paper_turntable, turntable_model
from tests.models.pens import call, matrix
from tests.models.test_process_noise import linear_parts
from tests.models.test_turntable import (
    CONFIGURATIONS,
    EXACT,
    ROTATION,
    SEEDS,
    random_state,
    readings,
    with_sensor,
)


@pytest.mark.parametrize("seed", SEEDS)
def test_mirror_is_the_table_turned_about_the_vertical(seed: int) -> None:
    x = random_state(seed)
    half_turn = np.diag([-1.0, -1.0, 1.0])
    mirrored = matrix(ROTATION, *mirror(x)[:2])
    assert mirrored == pytest.approx(matrix(ROTATION, *x[:2]) @ half_turn, abs=EXACT)


@pytest.mark.parametrize("sensors", CONFIGURATIONS, ids="+".join)
@pytest.mark.parametrize("seed", SEEDS)
def test_no_sensor_sees_the_mirror(sensors: tuple[str, ...], seed: int) -> None:
    """E7; also with sensors off the origin."""
    x = random_state(seed)
    for table in (paper_turntable(), with_sensor("accel", position_m=(0.03, -0.05, 0.07))):
        model = turntable_model(table, sensors)
        seen, mirrored = readings(model, x), readings(model, mirror(x))
        assert mirrored == pytest.approx(seen, rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("changed", [0, 1, 2])
def test_every_part_of_the_mirror_is_needed(changed: int) -> None:
    """With one of its three changes left out, the sensors see it."""
    model, x = turntable_model(paper_turntable()), random_state(1)
    partial = mirror(x)
    partial[changed] = x[changed]
    assert np.abs(readings(model, partial) - readings(model, x)).max() > 0.1


@pytest.mark.parametrize("seed", SEEDS)
def test_mirror_of_the_transition(seed: int) -> None:
    """Constant rates keep the mirror a mirror; φ's noise enters with the other sign."""
    model, x = turntable_model(paper_turntable()), random_state(seed)
    w = np.random.default_rng(seed).standard_normal(4)
    w_mirrored = w * [-1, 1, -1, 1]
    moved = mirror(call(model.f, x, w, 0.7))
    assert call(model.f, mirror(x), w_mirrored, 0.7) == pytest.approx(moved, rel=EXACT, abs=EXACT)
    _, Q = linear_parts(model, 0.7)
    flip = np.diag([-1.0, 1.0, -1.0, 1.0])
    assert pytest.approx(Q, rel=EXACT, abs=0) == flip @ Q @ flip


def test_twice_mirrored() -> None:
    """The same state, but for a turn of θ that `difference` takes out; the input stays."""
    model = turntable_model(with_sensor("gyro", bias_std_rad_s=0.1))
    states = np.array([[*random_state(seed), 0.2, -0.3] for seed in SEEDS])
    kept = states.copy()
    back = mirror(mirror(states))
    assert np.array_equal(states, kept)
    for state, again, once in zip(states, back, mirror(states), strict=True):
        assert call(model.difference, again, state) == pytest.approx(np.zeros(6), abs=EXACT)
        assert abs(call(model.difference, once, state)[1]) == pytest.approx(np.pi, rel=EXACT)
        assert np.array_equal(once[4:], state[4:])
