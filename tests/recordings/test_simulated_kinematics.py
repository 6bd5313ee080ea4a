"""Simulated, differentiated and estimated quantities agree.

The pen writes; positions and attitudes come from its path with SciPy's rotations, and
their differences in time are compared with what its sensors read.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ekf_baseline.ekf import Ekf
from estimation.estimator import run
from estimation.recording import Recording
from models.gaussian import GaussianState
from models.motion import white_jerk_motion
from models.motions import sample_motion
from models.noisy_readings import noisy_readings
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import parse_pen
from models.simulation import sample_times, true_states
from tests.models.pens import Array, random_rotation

MOTION, SEED, GRAVITY, FIXED_SPIN_RAD = "handwriting", 4, 9.81, 0.6
STEP_S = 1e-3
AGREEMENT = 1e-6
PLACES = {"accel": (0.01, -0.02, 0.11), "gyro": (0.0, 0.004, 0.1), "camera": (0.02, 0.01, 0.15)}
MATRICES = {
    name: np.array(random_rotation(np.random.default_rng(seed))) for seed, name in enumerate(PLACES)
}
ONE_POLE = float(np.sqrt(np.pi / 2))
STD: dict[str, dict[str, float]] = {
    "accel": {"noise_density_m_s2_per_sqrt_hz": 1e-5 / ONE_POLE, "bandwidth_hz": 1.0},
    "gyro": {"noise_density_rad_s_per_sqrt_hz": 1e-6 / ONE_POLE, "bandwidth_hz": 1.0},
    "camera": {"position_std_m": 1e-7, "orientation_std_rad": 1e-7},
}
KINDS = {"accel": "accelerometer", "gyro": "gyroscope", "camera": "pose_camera"}


def precise_pen(degrees_of_freedom: int) -> PenConfig:
    sensors: dict[str, Any] = {
        name: {
            "kind": kind,
            "position_m": PLACES[name],
            "sensor_to_body": MATRICES[name].tolist(),
            "rate_hz": 1 / STEP_S,
            **STD[name],
        }
        for name, kind in KINDS.items()
    }
    return parse_pen(
        {
            "name": "precise pen",
            "degrees_of_freedom": degrees_of_freedom,
            "gravity_m_s2": GRAVITY,
            "fixed_spin_rad": FIXED_SPIN_RAD,
            "motion": white_jerk_motion(100.0, 1000.0),
            "sensors": sensors,
        }
    )


def tip_and_attitude(time_s: Array, speed: float, dof: int) -> tuple[Array, Rotation]:
    """Return the tip (n, 3) and the rotations from body to world, by SciPy's Euler angles.

    Turn by ψ about z, lean from upright by π/2 - θ about y, turn by φ about z.
    """
    q = sample_motion(MOTION, time_s, seed=SEED, speed=speed).q
    spin = q[:, 5] if dof == 6 else np.full(len(q), FIXED_SPIN_RAD)
    angles = np.column_stack([q[:, 3], np.pi / 2 - q[:, 4], spin])
    return q[:, :3], Rotation.from_euler("ZYZ", angles)


def readings(dof: int, speed: float, duration_s: float) -> tuple[Array, dict[str, Array], Array]:
    """Return instants, readings without noise and true states."""
    model = pen_model(precise_pen(dof))
    time_s = sample_times(model, duration_s)["accel"]
    states = true_states(model, sample_motion(MOTION, time_s, seed=SEED, speed=speed), SEED)
    values = {
        name: noisy_readings(
            model.sensor(name), states, np.zeros((len(states), model.sensor(name).n_r))
        )
        for name in KINDS
    }
    return time_s, values, states


@pytest.mark.parametrize("dof", [5, 6])
@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_sensors_read_the_differences_of_the_path(dof: int, speed: float) -> None:
    time_s, values, _ = readings(dof, speed, 1.0)
    h = STEP_S / 2
    around = {k: tip_and_attitude(time_s + k * h, speed, dof) for k in (-2, -1, 0, 1, 2)}
    attitude = around[0][1]

    def places(name: str) -> dict[int, Array]:
        return {k: tip + turn.apply(PLACES[name]) for k, (tip, turn) in around.items()}

    p = places("accel")
    acceleration = (-p[-2] + 16 * p[-1] - 30 * p[0] + 16 * p[1] - p[2]) / (12 * h**2)
    force = attitude.inv().apply(acceleration + np.array([0, 0, GRAVITY])) @ MATRICES["accel"]
    np.testing.assert_allclose(values["accel"], force, rtol=0, atol=AGREEMENT)

    turn = {k: (attitude.inv() * around[k][1]).as_rotvec() for k in (-2, -1, 1, 2)}
    rate = (turn[-2] - 8 * turn[-1] + 8 * turn[1] - turn[2]) / (12 * h) @ MATRICES["gyro"]
    np.testing.assert_allclose(values["gyro"], rate, rtol=0, atol=AGREEMENT)

    target = attitude * Rotation.from_matrix(MATRICES["camera"])
    np.testing.assert_allclose(values["camera"][:, :3], places("camera")[0], rtol=0, atol=1e-14)
    seen = Rotation.from_rotvec(values["camera"][:, 3:])
    assert (target.inv() * seen).magnitude().max() < 1e-13


@pytest.mark.parametrize("dof", [5, 6])
def test_a_precise_pen_is_estimated_to_the_truth(dof: int) -> None:
    """The EKF on readings without noise: poses, velocities and rates to 1e-6 (m, rad, s).

    Nothing but the model's constant acceleration is wrong then: between samples 1 ms
    apart a jerk of 5 m/s³ or 50 rad/s³ takes the pen 1e-9 m or 1e-8 rad away from it,
    and noise levels are so small that the filter follows the readings. Poses are
    seen in every tenth sample only; between them accelerometer and gyroscope carry the
    estimate. The first 0.1 s are left to velocities wrong by 1e-2 at the start.
    """
    time_s, values, states = readings(dof, 1.0, 0.3)
    model = pen_model(precise_pen(dof))
    std = np.repeat([1e-4, 1e-2, 1.0], dof)
    wrong = std * np.random.default_rng(SEED).standard_normal(model.n_x)
    start = np.asarray(model.retract(states[0], wrong)).ravel()
    model = model.replace(prior=GaussianState(start, np.diag(std**2)))
    sensors = {name: (time_s, value) for name, value in values.items()}
    sensors["camera"] = (time_s[::10], values["camera"][::10])
    history = run(Ekf(model), Recording.from_sensors("exact", sensors))
    errors = np.abs(model.difference(history.mean.T, states.T).full().T)[:, : 2 * dof]
    assert errors[0, dof:].max() > 1e-3
    assert errors[time_s >= 0.1].max() < AGREEMENT
