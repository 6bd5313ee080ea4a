"""A gyroscope alone tells a free pen nothing of its attitude, however it is moved.

With P(t) the covariance of the attitude's error as a turn in the world, no eigenvalue of P(t)
relative to P(0) may fall below 1: what was known before is never known better. On Euler rates it
falls by factors, so the test sees what it is there to see.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimation.estimate import EstimateHistory
from estimation.estimator import run
from estimation.recording import Recording
from models.arrays import Array
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from tests.references.free_tangent import heading_of
from tests.references.spinning_euler_pen import spinning_euler_pen, turns_of_angles

SECONDS, PEN, GYRO = 60.0, load_pen("reference"), ("gyro",)
NEVER_BELOW = 0.99
ATTITUDE = slice(3, 6)
"""Of a free pen's state, and of a pen's with Euler angles."""


@dataclass(frozen=True, eq=False)
class Kept:
    """How much of what was not known before stays so, the least over a run.

    Parameters
    ----------
    relative : smallest eigenvalue of P(t) relative to P(0), world axes
    elevation : claimed deviation over the prior's own
    at_its_place : over what the prior, turned to where the pen is, says about that axis
    """

    relative: float
    elevation: float
    at_its_place: float


def recorded(seed: int, is_noisy: bool, seconds: float) -> Recording:
    """Handwriting; without noise the gyroscope reads truth and bias, and rounds nothing."""
    recording = simulate(PEN, GYRO, motion="handwriting", duration_s=seconds, seed=seed)
    if is_noisy:
        return recording
    model, truth = free_model(False), recording.truth
    assert truth is not None
    states = truth.states(model.state_names, recording.time_s)
    exact = model.sensor("gyro").h(states.T).full().T
    return replace(recording, readings={"gyro": exact})


@cache
def free_model(writing_area: bool) -> StateSpaceModel:
    return pen_model(PEN, GYRO, writing_area=writing_area)


@cache
def euler_model() -> StateSpaceModel:
    return spinning_euler_pen(PEN, GYRO)


def kept(turns: Array, prior_turn: Array, model: StateSpaceModel, history: EstimateHistory) -> Kept:
    """Compare covariances with the prior's.

    Parameters
    ----------
    turns : (n, 3, 3) from a tangent vector's attitude to a turn in the world
    prior_turn : (3, 3) the same of the prior
    """
    P = turns @ history.covariance[:, ATTITUDE, ATTITUDE] @ turns.transpose(0, 2, 1)
    P0 = prior_turn @ model.prior.covariance[ATTITUDE, ATTITUDE] @ prior_turn.T
    whiten = np.linalg.inv(np.linalg.cholesky(P0))
    relative = np.linalg.eigvalsh(whiten @ P @ whiten.T).min()
    azimuth = history.column("azimuth_rad")
    # The elevation turns about a horizontal axis that goes with the azimuth.
    axis = np.column_stack([-np.sin(azimuth), np.cos(azimuth), np.zeros_like(azimuth)])
    there = np.sqrt(np.einsum("ni,ij,nj->n", axis, P0, axis))
    claimed = history.std_of("elevation_rad")
    return Kept(
        float(relative),
        float(claimed.min() / PEN.prior.elevation_std_rad),
        float((claimed / there).min()),
    )


def kept_free(estimator: str, recording: Recording, writing_area: bool) -> Kept:
    model = free_model(writing_area)
    history = run(create_estimator(estimator, model), recording, covariances=True)
    turns = heading_of(Rotation.from_mrp(history.mean[:, ATTITUDE])).as_matrix()
    prior_turn = heading_of(Rotation.from_mrp(model.prior.mean[ATTITUDE].copy())).as_matrix()
    return kept(turns, prior_turn, model, history)


def kept_on_euler_rates(estimator: str, recording: Recording) -> Kept:
    model = euler_model()
    history = run(create_estimator(estimator, model), recording, covariances=True)
    turns = turns_of_angles(history.column("azimuth_rad"), history.column("elevation_rad"))
    prior_turn = turns_of_angles(*model.prior.mean[3:5, None])[0]
    return kept(turns, prior_turn, model, history)


def assert_nothing_learnt(found: Kept) -> None:
    assert found.relative > NEVER_BELOW
    assert found.elevation > NEVER_BELOW
    assert found.at_its_place > NEVER_BELOW


@pytest.mark.parametrize(
    ("estimator", "writing_area", "is_noisy"),
    [
        ("ekf", False, True),
        ("ekf", True, False),
        ("mhe-rti", False, False),
        ("mhe-rti", True, True),
    ],
)
def test_a_gyroscope_alone_says_nothing_of_the_attitude(
    estimator: str, writing_area: bool, is_noisy: bool
) -> None:
    seconds = SECONDS if estimator == "ekf" else SECONDS / 4
    assert_nothing_learnt(kept_free(estimator, recorded(0, is_noisy, seconds), writing_area))


@pytest.mark.slow
@pytest.mark.parametrize("is_noisy", [False, True])
@pytest.mark.parametrize("writing_area", [False, True])
@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_nor_in_twenty_runs_of_a_minute(estimator: str, writing_area: bool, is_noisy: bool) -> None:
    for seed in range(20):
        assert_nothing_learnt(kept_free(estimator, recorded(seed, is_noisy, SECONDS), writing_area))


@pytest.mark.parametrize("is_noisy", [False, True])
def test_on_euler_rates_it_would_say_much(is_noisy: bool) -> None:
    """The test of the test."""
    for seed in range(2):
        found = kept_on_euler_rates("ekf", recorded(seed, is_noisy, SECONDS))
        assert found.relative < 0.2 < NEVER_BELOW
        assert found.elevation < 0.5
