"""A paper that is not level: what an accelerometer reads on it, and what a pen that knows gains."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ekf_baseline import Ekf
from estimation.estimator import run
from mhe.reuse import sensors_hold_all
from models.errors import InputError
from models.level import UP, up_direction
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen, parse_pen
from models.printed import PRINTED_ERRORS
from recordings.simulate_pen import simulate
from tests.models.pens import ACCELEROMETER, call, every_sensor, pen, random_state

LEVEL_RAD = (0.02, -0.03)
INERTIAL = ("accel", "gyro")


def up(level_rad: tuple[float, float]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Up in the paper's axes, by SciPy: the z axis of gravity's frame."""
    return np.asarray(Rotation.from_rotvec([*level_rad, 0.0]).apply([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("level_rad", [LEVEL_RAD, (0.3, 0.0), (0.0, -0.5), (1e-9, 2e-9)])
def test_up_is_the_turned_z_axis(level_rad: tuple[float, float]) -> None:
    np.testing.assert_allclose(up_direction(level_rad), up(level_rad), rtol=0, atol=1e-15)


def test_signs_are_those_of_the_docstring() -> None:
    assert up_direction((0.1, 0.0))[1] < 0 < up_direction((0.0, 0.1))[0]
    assert up_direction((0.0, 0.0)) == UP


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_an_accelerometer_reads_gravity_along_up(degrees_of_freedom: int) -> None:
    """B (p̈ + g up): what changes is B g (up - e_z), by the attitude that SciPy has."""
    rng = np.random.default_rng(degrees_of_freedom)
    sensors = every_sensor(rng)
    level, leaning = (
        pen_model(pen(degrees_of_freedom, sensors, level_rad=angles))
        for angles in ((0.0, 0.0), LEVEL_RAD)
    )
    x = random_state(rng, degrees_of_freedom, level.n_x - 3 * degrees_of_freedom)
    if degrees_of_freedom == 6:
        B = Rotation.from_mrp(x[3:6]).as_matrix().T
    else:
        spin = pen(5, sensors).fixed_spin_rad
        B = Rotation.from_euler("ZYZ", [x[3], np.pi / 2 - x[4], spin]).as_matrix().T
    mounted = np.array(sensors["accel"].sensor_to_body).T
    expected = mounted @ B @ (9.81 * (up(LEVEL_RAD) - [0, 0, 1]))
    for name in ("accel", "gyro", "camera", "contact"):
        more = call(leaning.sensor(name).h, x) - call(level.sensor(name).h, x)
        np.testing.assert_allclose(more, expected if name == "accel" else 0, atol=1e-12)


def test_a_printed_pen_leans_too() -> None:
    sensors = {"accel": {"kind": "accelerometer", **ACCELEROMETER}}
    common = {"printed_errors": PRINTED_ERRORS, "fixed_spin_rad": 0.0}
    x = random_state(np.random.default_rng(0), 5)
    level, leaning = (
        call(pen_model(pen(5, sensors, **common, level_rad=angles)).sensor("accel").h, x)
        for angles in ((0.0, 0.0), LEVEL_RAD)
    )
    B = Rotation.from_euler("ZYZ", [x[3], np.pi / 2 - x[4], 0.0]).as_matrix().T
    np.testing.assert_allclose(leaning - level, B @ (9.81 * (up(LEVEL_RAD) - UP)), atol=1e-12)


def test_the_file_takes_degrees_and_refuses_a_wall() -> None:
    data = load_pen("dpoint").model_dump(exclude={"level_rad"}, exclude_none=True)
    assert parse_pen(data).level_rad == (0.0, 0.0)
    assert parse_pen({**data, "level_deg": [0.5, -0.25]}).level_rad == pytest.approx(
        np.radians([0.5, -0.25])
    )
    with pytest.raises(InputError, match="key level_rad: expected a frame turned by less than 90"):
        parse_pen({**data, "level_deg": [80, 60]})


def test_heading_is_a_turn_about_gravity() -> None:
    """No inertial sensor sees it; a turn about the paper's z axis is another thing."""
    rng = np.random.default_rng(3)
    model = pen_model(pen(6, every_sensor(rng), level_rad=LEVEL_RAD))
    x = random_state(rng, 6, model.n_x - 18)
    (symmetry,) = model.symmetries
    seen = call(symmetry, x, 0.7)
    turn = Rotation.from_rotvec(0.7 * up(LEVEL_RAD))
    for rows in (slice(6, 9), slice(12, 15)):
        np.testing.assert_allclose(seen[rows], turn.apply(x[rows]), rtol=0, atol=1e-13)
    for name in INERTIAL:
        h = model.sensor(name).h
        np.testing.assert_allclose(call(h, seen), call(h, x), rtol=0, atol=1e-12)
    assert pen_model(pen(5, every_sensor(rng), level_rad=LEVEL_RAD)).symmetries == ()


def reference(**others: Any) -> PenConfig:
    return load_pen("reference").model_copy(update=others)


def test_factors_are_not_kept_where_the_heading_is_unseen() -> None:
    model = pen_model(reference(level_rad=LEVEL_RAD), INERTIAL, writing_area=False)
    assert not sensors_hold_all(model)


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_a_pen_that_knows_its_level_is_right_and_another_is_off(degrees_of_freedom: int) -> None:
    """The camera is trusted little and the tip moves little: gravity says how the pen leans."""
    sensors = ("accel", "gyro", "camera")
    data = reference(degrees_of_freedom=degrees_of_freedom).sensors
    camera = data["camera"].model_copy(update={"orientation_std_rad": 0.1, "position_std_m": 1e-3})
    accel = data["accel"].model_copy(
        update={"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0}
    )
    motion = reference().motion
    tip = motion.tip.model_copy(update={"speed_m_s": 0.005})
    slow = motion.model_copy(update={"tip": tip})
    true, level = (
        reference(
            degrees_of_freedom=degrees_of_freedom,
            sensors={**data, "camera": camera, "accel": accel},
            level_rad=angles,
            motion=slow,
        )
        for angles in ((0.0, 0.05), (0.0, 0.0))
    )
    recording = simulate(true, sensors, motion="still", duration_s=2.0, seed=1)
    assert recording.truth is not None
    errors, claimed = [], []
    for config in (true, level):
        history = run(Ekf(pen_model(config, sensors)), recording)
        late = history.time_s > 1
        true_elevation = recording.truth.states(["elevation_rad"], history.time_s)[:, 0]
        errors.append((history.column("elevation_rad") - true_elevation)[late])
        claimed.append(history.std_of("elevation_rad")[late])
    assert np.abs(errors[0] / claimed[0]).max() < 4
    azimuth = math.radians(-30.0)  # of the still pen: up leans along x, the pen along its axis
    assert errors[1].mean() == pytest.approx(0.05 * math.cos(azimuth), abs=2e-3)
