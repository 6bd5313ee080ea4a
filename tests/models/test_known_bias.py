"""What a calibration found of a sensor, in its reading and in the prior of its bias."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from models.arrays import Array
from models.errors import InputError
from models.pen_file import parse_pen

S = np.array([[1.02, 0.003, -0.01], [0.004, 0.97, 0.005], [-0.02, 0.006, 1.01]])
BIAS = [0.3, -0.2, 0.1]
SENSORS = ["accel", "gyro", "camera"]


def pen(**keys: Any) -> pm.PenConfig:
    """Return the reference pen whose accelerometer has other keys."""
    data = pm.load_pen("reference").model_dump()
    data["sensors"]["accel"] |= keys
    return parse_pen(data)


def force_at_rest(config: pm.PenConfig, bias: Array) -> Array:
    """Return what the accelerometer of a pen that stands upright reads."""
    model = pm.pen_model(config, ["accel"])
    x = model.prior.mean.copy()
    x[3:6] = 0.0
    for i, name in enumerate(name for name in model.state_names if "_bias_" in name):
        x[model.state_names.index(name)] = bias[i]
    return np.asarray(model.sensors[0].h(x)).ravel()


def test_a_reading_is_the_force_times_the_sensitivity_and_a_bias() -> None:
    up = force_at_rest(pen(), np.zeros(3))
    assert np.linalg.norm(up) == pytest.approx(9.81)
    found = force_at_rest(pen(sensitivity=S.tolist(), bias_m_s2=BIAS), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(found, S @ up + [1.0, 2.0, 3.0], atol=1e-12)


def test_a_known_bias_is_where_its_state_begins() -> None:
    model = pm.pen_model(pen(bias_m_s2=BIAS, axes=["z", "x"]), ["accel", "gyro"])
    states = [model.state_names.index(f"accel_bias_{axis}_m_s2") for axis in "zx"]
    assert model.prior.mean[states] == pytest.approx([BIAS[2], BIAS[0]])
    others = [i for i, name in enumerate(model.state_names) if name.startswith("gyro_bias")]
    assert not model.prior.mean[others].any()


def test_one_without_a_state_is_taken_as_exact() -> None:
    none = {"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0}
    model = pm.pen_model(pen(**none, bias_m_s2=BIAS), ["accel"])
    assert not any("_bias_" in name for name in model.state_names)
    known: dict[str, Any] = {"bias_m_s2": BIAS}
    up, found = (force_at_rest(pen(**none, **more), np.zeros(0)) for more in ({}, known))
    np.testing.assert_allclose(found - up, BIAS, atol=1e-12)


@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_estimates_are_those_of_corrected_readings(name: str) -> None:
    """A scale of all axes and a bias, taken off the readings by hand, to rounding."""
    scale = 1.03
    accel = pm.load_pen("reference").sensors["accel"].model_dump()
    keys = ("noise_density_m_s2_per_sqrt_hz", "bias_std_m_s2", "bias_walk_m_s2_per_sqrt_s")
    scaled = {key: scale * accel[key] for key in keys}
    # A quantised sensor's steps would differ.
    crude = pen(
        **scaled, sensitivity=(scale * np.eye(3)).tolist(), bias_m_s2=BIAS, resolution_m_s2=0.0
    )
    fine = pen(resolution_m_s2=0.0)
    recording = pm.simulate(crude, SENSORS, motion="turn", duration_s=0.4, seed=2)
    corrected = pm.Recording(
        "corrected",
        recording.time_s,
        {**recording.readings, "accel": (recording.readings["accel"] - BIAS) / scale},
    )
    found, expected = (
        pm.run(pm.create_estimator(name, pm.pen_model(of, SENSORS)), readings)
        for of, readings in ((crude, recording), (fine, corrected))
    )
    column = found.state_names.index("accel_bias_x_m_s2")
    shift = np.zeros(found.mean.shape[1])
    shift[column : column + 3] = BIAS
    size = np.ones_like(shift)
    size[column : column + 3] = scale
    away = (found.mean - shift) / size - expected.mean
    assert np.abs(away / expected.std).max() < 1e-6
    np.testing.assert_allclose(found.std / size, expected.std, rtol=1e-6)


def test_a_matrix_far_from_one_is_refused() -> None:
    with pytest.raises(InputError, match=r"sensors\.accel\.sensitivity: expected a matrix near"):
        pen(sensitivity=[[2, 0, 0], [0, 1, 0], [0, 0, 1]])
