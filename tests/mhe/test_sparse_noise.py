"""Sparse noise follows a rate that jumps and is otherwise constant: the turntable's."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import Mhe
from models.arrays import Array
from models.turntable import paper_turntable, turntable_model
from tests.configs import config_for
from tests.mhe.runs import run_mhe
from tests.mhe.windows import moves

MODEL = turntable_model(paper_turntable(), ["accel", "gyro"])
DT, N, STOPS, STARTS = 0.01, 101, 50, 70
RATES, SPARSE = slice(2, 4), 0.5


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def table_that_stops_and_starts(seed: int) -> tuple[Array, list[Measurement]]:
    """φ turns and stops, θ stands and starts; true states and noisy readings."""
    rng = np.random.default_rng(seed)
    rate = np.zeros((N, 2))
    rate[:STOPS, 0], rate[STARTS:, 1] = np.deg2rad(5.1), np.deg2rad(3.6)
    angle = np.vstack([np.zeros(2), np.cumsum(DT * rate[:-1], axis=0)])
    states = np.hstack([angle, rate])
    measurements = []
    for k, x in enumerate(states):
        h = np.concatenate([np.asarray(sensor.h(x)).ravel() for sensor in MODEL.sensors])
        y = h + MODEL.noise_std * rng.standard_normal(len(h))
        measurements.append(Measurement(k * DT, y))
    return states, measurements


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("estimator", "share"), [("mhe-rti", 0.85), ("mhe", 0.6)])
def test_a_live_estimate_follows_sharper(estimator: str, share: float, seed: int) -> None:
    """Than by least squares: over all, behind the stop, and without more noise before it."""
    truth, measurements = table_that_stops_and_starts(seed)
    every, behind, still = slice(None), slice(STOPS + 2, STOPS + 9), slice(25, STOPS)
    error = {}
    for sparse_noise in (None, SPARSE):
        config = config_for(estimator, horizon=40, sparse_noise=sparse_noise)
        estimates = run_mhe(MODEL, measurements, config, estimator)
        assert all(estimate.status.is_solved for estimate in estimates)
        away = np.array([estimate.state.mean for estimate in estimates]) - truth
        error[sparse_noise] = [rms(away[part, RATES]) for part in (every, behind, still)]
    plain, sparse = error[None], error[SPARSE]
    assert sparse[0] < share * plain[0]
    assert sparse[1] < 0.6 * plain[1]
    assert sparse[2] < 1.2 * plain[2]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_whole_window_has_two_jumps(seed: int) -> None:
    """Nearly all noise is at the stop and at the start; least squares spreads it."""
    truth, measurements = table_that_stops_and_starts(seed)
    shares, errors = [], []
    for sparse_noise in (None, SPARSE):
        mhe = Mhe(MODEL, MheConfig(horizon=N - 1, sparse_noise=sparse_noise))
        found = moves(mhe, measurements)[-1].found
        squares = (found.noises**2).sum(axis=1)
        near = [k + i for k in (STOPS - 1, STARTS - 1) for i in (-1, 0, 1)]
        shares.append(squares[near].sum() / squares.sum())
        errors.append(rms((found.states - truth)[:, RATES]))
    assert shares[1] > 0.9 > 0.5 > shares[0]
    assert errors[1] < 0.5 * errors[0]
