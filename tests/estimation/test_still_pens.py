"""A pen held still is known no better than its sensors allow, and no worse than it claims."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from models.pen import pen_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from tests.estimation.resting import INERTIAL, pen_at_rest
from tests.estimation.still_pens import (
    Judged,
    Movement,
    judged,
    off_by,
    picked_up,
    recorded,
    still,
    trembling,
    turning,
)

DEG = np.pi / 180
PEN = pen_at_rest()


@cache
def model(rest: bool = True) -> StateSpaceModel:
    return pen_model(PEN, INERTIAL, rest=rest)


@cache
def estimator(name: str, rest: bool = True) -> Any:
    return create_estimator(name, model(rest))


@cache
def floor_rad() -> float:
    """√(1 / (1/σ_prior² + g²/σ_bias²)): what tilt and bias leave of each other."""
    bias = PEN.sensors["accel"].bias_states("accel").std / PEN.gravity_m_s2
    return 1 / np.hypot(1 / PEN.prior.elevation_std_rad, 1 / bias)


def after(name: str, seeds: range, instants_s: tuple[float, ...], rest: bool = True) -> Judged:
    """Return what is said at instants (seeds, n) of still pens."""
    found = [
        judged(
            estimator(name, rest),
            recorded(PEN, model(rest), still, duration_s=instants_s[-1], seed=seed),
            instants_s,
        )
        for seed in seeds
    ]
    return Judged(*(np.array([getattr(each, field) for each in found]) for field in vars(found[0])))


def must_hold(said: Judged) -> None:
    assert (np.abs(said.error) <= 3 * said.claimed).mean() >= 0.95
    assert (np.abs(said.bias_error) <= 3 * said.bias_claimed).mean() >= 0.95
    assert (said.claimed > 0.95 * floor_rad()).all()
    assert (said.claimed < 1.3 * floor_rad()).all()


def test_a_minute() -> None:
    said = after("ekf", range(4), (10.0, 60.0))
    must_hold(said)
    assert said.bias_claimed[:, -1] == pytest.approx(0.006 * DEG, rel=0.1)


@pytest.mark.slow
def test_without_rest_confidence_is_false() -> None:
    """A test of the test: the bias about the vertical is off by many claims within minutes."""
    said = after("ekf", range(4), (300.0,), rest=False)
    assert said.claimed.min() < 0.97 * floor_rad()
    assert np.sqrt(np.mean((said.bias_error / said.bias_claimed) ** 2)) > 5


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seeds"), [("ekf", 20), ("mhe-rti", 3)])
def test_twenty_minutes(name: str, seeds: int) -> None:
    must_hold(after(name, range(seeds), (60.0, 300.0, 1200.0)))


@pytest.mark.slow
def test_two_hours() -> None:
    must_hold(after("ekf", range(3), (7200.0,)))


MOVEMENTS: dict[str, tuple[Movement, float]] = {
    "picked up after a minute": (picked_up(60.0), 80.0),
    "turning by 0.5 °/s": (turning(0.5 * DEG), 40.0),
    "turning by 2 °/s": (turning(2 * DEG), 40.0),
    "turning by 6 °/s": (turning(6 * DEG), 40.0),
    "trembling, 0.05 mm": (trembling(5e-5, 0.5 * DEG), 60.0),
    "trembling, 0.2 mm": (trembling(2e-4, 1 * DEG), 60.0),
}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seeds"), [("ekf", 20), ("mhe-rti", 5)])
@pytest.mark.parametrize("movement", list(MOVEMENTS))
def test_movements(movement: str, name: str, seeds: int) -> None:
    moved, duration_s = MOVEMENTS[movement]
    off = np.concatenate(
        [
            off_by(estimator(name), recorded(PEN, model(), moved, duration_s=duration_s, seed=seed))
            for seed in range(seeds)
        ]
    )
    print(movement, name, np.sqrt(np.mean(off**2)), np.abs(off).max())
    assert (np.abs(off) <= 3).mean() >= 0.95
