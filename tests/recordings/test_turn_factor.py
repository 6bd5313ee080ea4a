"""The factor between a gyroscope's rates and the turning of gravity, and when it is withheld."""

from __future__ import annotations

import numpy as np
import pytest

from models.units import STANDARD_GRAVITY_M_S2
from recordings.turn_factor import turn_factor
from tests.recordings.swings import swinging

DEG, G = np.pi / 180, STANDARD_GRAVITY_M_S2


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("factor", [1.0, DEG, 1 / DEG])
def test_factor_of_a_rotation_in_place(seed: int, factor: float) -> None:
    """Without acceleration the equation is exact, on irregular and different stamps."""
    t, rate, up = swinging(seed)
    k = turn_factor(t[::2], G * up[::2], t[1::2], rate[1::2] / factor)
    assert k is not None
    assert k == pytest.approx(factor, rel=0.01)


def test_rest_and_bias_do_not_hide_the_turning() -> None:
    """A minute at rest, in which the gyroscope shows its bias, before ten seconds of turning."""
    t, rate, up = swinging(2)
    before = np.arange(-60, 0, 0.005)
    still = np.tile(up[0], (len(before), 1))
    times, force = np.concatenate([before, t]), np.vstack([still, up])
    rates = np.vstack([np.zeros_like(still), rate]) + np.array([2 * DEG, -2 * DEG, 0])
    assert turn_factor(times, force, times, rates) == pytest.approx(1.0, rel=0.1)


def test_few_and_irregular_samples() -> None:
    """13 a second, none more than 0.1 s after the one before."""
    t, rate, up = swinging(6, 30.0)
    wanted = np.arange(0, 30, 1 / 13) + np.random.default_rng(0).uniform(-0.01, 0.01, 390)
    few = np.unique(np.searchsorted(t, wanted[1:]))
    assert turn_factor(t[few], up[few], t[few], rate[few]) == pytest.approx(1.0, rel=0.02)


def test_no_factor_without_evidence() -> None:
    t, rate, up = swinging(0)
    rng = np.random.default_rng(1)
    still = np.tile([0.0, 0.0, 9.8], (len(t), 1)) + rng.normal(0, 0.02, (len(t), 3))
    assert turn_factor(t, still, t, rng.normal(0.02, 0.002, (len(t), 3))) is None
    assert turn_factor(t, still, t, rate) is None
    # Turning too little: what the hand pushes would count for more.
    little, little_rate, little_up = swinging(0, swing_rad=0.01)
    assert turn_factor(little, little_up, little, little_rate) is None
    # A gyroscope that says something else, nothing, or is mounted as nobody said.
    assert turn_factor(t, up, t, swinging(7)[1]) is None
    assert turn_factor(t, up, t, np.zeros_like(rate)) is None
    assert turn_factor(t, up, t, -rate) is None
    assert turn_factor(t, up, t[:0], rate[:0]) is None
    # Shaken, too short, or too sparse.
    shaken = up + 0.5 * np.sin(40 * t)[:, None]
    assert turn_factor(t, shaken, t, rate) is None
    assert turn_factor(t[t < 2], up[t < 2], t[t < 2], rate[t < 2]) is None
    assert turn_factor(t[::40], up[::40], t[::40], rate[::40]) is None


@pytest.mark.parametrize("seed", range(3))
def test_a_push_for_a_while_counts_for_little(seed: int) -> None:
    """Three of twenty seconds, sideways, so that the norm of the force hardly shows it.

    Least squares would be off by up to 6 %.
    """
    t, rate, up = swinging(seed, 20.0, swing_rad=0.1)
    push = 0.4 * np.sin(2 * np.pi * 0.8 * t) * ((t > 4) & (t < 7))
    pushed = up + push[:, None] * np.cross(up, [1.0, 0.0, 0.0])
    assert turn_factor(t, pushed, t, rate) == pytest.approx(1.0, rel=0.005)
