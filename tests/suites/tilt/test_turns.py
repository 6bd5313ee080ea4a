from __future__ import annotations

import numpy as np
import pytest

from models.turntable import turntable_model
from suites.tilt.cases import CASES, FULL_TURN
from suites.tilt.samples import SENSORS, tilt_tracker
from suites.tilt.turns import Tilting, Turn, gravity_direction, tilts_of


@pytest.mark.parametrize("case", CASES)
def test_rates_are_derivatives_of_the_tilts(case: str) -> None:
    turn = CASES[case].turn
    time_s, h = np.linspace(0.0, turn.duration_s, 200), 1e-5
    # At the ends of the motion the rate has a corner: central differences lose an order.
    derivative = (turn.states(time_s + h) - turn.states(time_s - h))[:, :2] / (2 * h)
    np.testing.assert_allclose(turn.states(time_s)[:, 2:], derivative, atol=1e-4)


@pytest.mark.parametrize("case", CASES)
def test_turns_begin_and_end_at_rest_and_stay_off_the_singular_tilt(case: str) -> None:
    turn = CASES[case].turn
    time_s = np.linspace(0.0, turn.duration_s, 1000)
    states = turn.states(time_s)
    resting = (time_s <= turn.resting_s) | (time_s >= turn.duration_s - turn.resting_s)
    assert np.abs(states[resting, 2:]).max() < 1e-12
    low, high = tilt_tracker().tilt_phi.range_rad
    assert low < states[:, 0].min() <= states[:, 0].max() < high


def test_the_full_turn_goes_once_around() -> None:
    theta = CASES[FULL_TURN].turn.states(np.linspace(0.0, 12.0, 500))[:, 1]
    assert theta[0] == 0
    assert theta[-1] == pytest.approx(2 * np.pi)
    assert (np.diff(theta) >= 0).all()


def test_direction_is_what_the_model_reads_at_rest() -> None:
    tracker = tilt_tracker()
    model = turntable_model(tracker, SENSORS)
    states = Turn(Tilting(swing_deg=70.0), Tilting(turn_deg=300.0)).states(np.linspace(0, 12, 50))
    reads = model.sensor("accel").h(states.T).full().T
    direction = gravity_direction(states[:, 0], states[:, 1])
    np.testing.assert_allclose(tracker.gravity_m_s2 * direction, reads, atol=1e-12)
    phi, theta = tilts_of(direction)
    np.testing.assert_allclose(phi, states[:, 0], atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * theta), np.exp(1j * states[:, 1]), atol=1e-12)
