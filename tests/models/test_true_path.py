"""The truth of a simulation, by name, against SciPy's rotations and five-point differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.euler_pen import kinematic_states
from models.free_kinematics import QUATERNION
from models.free_pen import STATES
from models.motions import SampledMotion, motions, sample_motion
from models.true_path import TRUE_NAMES, true_path
from tests.references.free_states import body_to_world, free_states

H = 1e-3
TIMES = np.arange(41) * 0.05
MOTIONS = ["turn", "handwriting", "upright"]
BODY_RATE = [f"body_rate_{axis}_rad_s" for axis in "xyz"]
BODY_ACCELERATION = [f"body_acceleration_{axis}_rad_s2" for axis in "xyz"]


def sampled(name: str, shift: float = 0.0) -> SampledMotion:
    return sample_motion(name, TIMES + 0.02 + shift)


def columns(path: object, names: list[str]) -> Array:
    return np.column_stack([path[name] for name in names])  # type: ignore[index]


def test_every_state_and_output_of_either_pen_has_a_name() -> None:
    path = true_path(sampled("turn"))
    assert set(path) == set(TRUE_NAMES)
    assert len(set(TRUE_NAMES)) == len(TRUE_NAMES)
    names = {name for n in (5, 6) for name, _ in kinematic_states(n)}
    assert names | {name for name, _ in STATES} | set(QUATERNION) == set(TRUE_NAMES)
    assert all(path[name].shape == TIMES.shape for name in TRUE_NAMES)


@pytest.mark.parametrize("name", MOTIONS)
def test_the_attitude_is_scipys(name: str) -> None:
    motion = sampled(name)
    path, R = true_path(motion), body_to_world(*motion.q[:, 3:].T)
    sigma = columns(path, ["mrp_x", "mrp_y", "mrp_z"])
    assert np.linalg.norm(sigma, axis=1).max() <= 1 + 1e-14
    assert (R.inv() * Rotation.from_mrp(sigma)).magnitude().max() < 1e-14
    quaternion = columns(path, list(QUATERNION))
    expected = R.as_quat(canonical=True)[:, [3, 0, 1, 2]]
    assert quaternion == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("name", MOTIONS)
def test_rates_and_their_derivatives_are_differences(name: str) -> None:
    """ω = vee(Rᵀ Ṙ) and α = ω̇, by five points in time; and both in closed form."""
    shifted = {k: sampled(name, k * H) for k in (-2, -1, 0, 1, 2)}
    R = {k: body_to_world(*motion.q[:, 3:].T) for k, motion in shifted.items()}
    turn = {k: (R[0].inv() * R[k]).as_rotvec() for k in R}
    path = true_path(shifted[0])
    rate = (8 * (turn[1] - turn[-1]) - (turn[2] - turn[-2])) / (12 * H)
    found = columns(path, BODY_RATE)
    size = np.abs(found).max()
    assert found == pytest.approx(rate, abs=1e-6 * size)
    omega = {k: columns(true_path(motion), BODY_RATE) for k, motion in shifted.items()}
    slope = (8 * (omega[1] - omega[-1]) - (omega[2] - omega[-2])) / (12 * H)
    found = columns(path, BODY_ACCELERATION)
    assert found == pytest.approx(slope, abs=1e-5 * np.abs(found).max())


@pytest.mark.parametrize("name", MOTIONS)
def test_all_in_closed_form(name: str) -> None:
    motion = sampled(name)
    euler = np.hstack([motion.q, motion.q_dot, motion.q_ddot])
    path, expected = true_path(motion), free_states(euler)
    for k, (state, _) in enumerate(STATES):
        if not state.startswith("mrp"):
            size = max(1.0, float(np.abs(expected[:, k]).max()))
            assert path[state] == pytest.approx(expected[:, k], abs=1e-12 * size), state
    for k, (state, _) in enumerate(kinematic_states(6)):
        assert np.array_equal(path[state], euler[:, k]), state


def test_the_motions_of_these_tests_are_there() -> None:
    assert set(MOTIONS) <= set(motions())
