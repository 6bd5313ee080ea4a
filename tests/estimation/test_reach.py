"""A tip that no sensor holds drifts out of reach, and its status says so from that step on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run, run_measurements
from estimation.recording import Measurement, Recording
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.arrays import Array
from models.errors import InputError
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.pen_config import Prior
from models.state_space import StateSpaceModel
from tests.estimation.exact_motions import INERTIAL, POSE, SENSORS, first_state
from tests.linear_models import random_walk_system
from tests.models.pens import call, pen

pytestmark = pytest.mark.usefixtures("interpreted")

JERK, PRIOR_STD = 3.0, (0.05, 0.1, 0.4)
"""Of the tip: m/s³/√Hz; m, m/s, m/s²."""
SLOW: dict[str, Any] = {
    "motion": white_jerk_motion(JERK, 20.0),
    "prior": Prior(
        tip_std_m=PRIOR_STD[0],
        velocity_std_m_s=PRIOR_STD[1],
        acceleration_std_m_s2=PRIOR_STD[2],
        azimuth_rad=POSE[3] - 0.1,
        azimuth_std_rad=0.3,
        spin_rad=POSE[5] + 0.1,
        spin_std_rad=0.3,
    ),
}
"""A pen whose drift takes a second or two, started near its pose."""

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Estimator[Any]]] = {
    "ekf": Ekf,
    "mhe-ipopt": lambda model: MheIpopt(model, MheIpoptConfig(horizon=2)),
}


def at_rest(model: StateSpaceModel, duration_s: float, rate_hz: float = 20.0) -> Recording:
    """Readings without noise of a pen that is held still."""
    times = np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    x = first_state(model.n_x // 3)
    readings = {
        sensor.name: np.tile(call(sensor.h, x), (len(times), 1))
        for sensor in model.measured_sensors
    }
    return Recording("held still", times, readings)


def unseen_tip_std(t: Array) -> Array:
    """White jerk from the prior on: σ² = σ_p² + σ_v² t² + σ_a² t⁴/4 + S² t⁵/20."""
    p, v, a = PRIOR_STD
    return np.asarray(np.sqrt(p**2 + v**2 * t**2 + a**2 * t**4 / 4 + JERK**2 * t**5 / 20))


def out_of_reach(history: EstimateHistory) -> Array:
    return np.array([Status.OUT_OF_REACH in status for status in history.status])


@pytest.mark.cover
@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
@pytest.mark.parametrize("reach", [{}, {"reach_m": 0.7}])
def test_a_gyroscopes_pen_is_out_of_reach_when_white_jerk_says_so(
    name: str, degrees_of_freedom: int, reach: dict[str, float]
) -> None:
    """No reading says anything of the tip: see `unseen_tip_std`."""
    config = pen(degrees_of_freedom, SENSORS, **SLOW, **reach)
    model = pen_model(config, ["gyro"], writing_area=False)
    history = run(ESTIMATORS[name](model), at_rest(model, 2.0))
    std = unseen_tip_std(history.time_s)
    for axis in range(3):
        np.testing.assert_allclose(history.std[:, axis], std, rtol=1e-6)
    np.testing.assert_array_equal(out_of_reach(history), std > reach.get("reach_m", 2.0))
    assert not out_of_reach(history)[:5].any()
    assert out_of_reach(history)[-5:].all()
    assert history.solved_fraction == 1.0


@pytest.mark.cover
@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_an_accelerometer_does_not_hold_the_tip(name: str, degrees_of_freedom: int) -> None:
    """Its tilt error is an acceleration: it is only later out of reach than without it."""
    config = pen(degrees_of_freedom, SENSORS, **SLOW)
    model = pen_model(config, ["accel", "gyro"], writing_area=False)
    duration_s = 8.0 if name == "ekf" else 4.0
    history = run(ESTIMATORS[name](model), at_rest(model, duration_s))
    worst = history.std[:, :3].max(axis=1)
    np.testing.assert_array_equal(out_of_reach(history), worst > 2.0)
    assert (worst <= unseen_tip_std(history.time_s) * (1 + 1e-9)).all()
    first = int(np.argmax(out_of_reach(history)))
    assert 0 < first < len(history) - 5
    assert out_of_reach(history)[first:].all()


@pytest.mark.parametrize("degrees_of_freedom", [pytest.param(5, marks=pytest.mark.slow), 6])
@pytest.mark.parametrize(
    "inertial",
    [
        pytest.param(name, marks=() if name in ("gyro", "accel+gyro") else pytest.mark.slow)
        for name in INERTIAL
    ],
)
def test_the_writing_area_holds_the_tip(degrees_of_freedom: int, inertial: str) -> None:
    """For a minute, with the default process noise, livelier than a pen's."""
    model = pen_model(pen(degrees_of_freedom, SENSORS), INERTIAL[inertial])
    assert model.sensors[-1].kind == "writing_area"
    history = run(Ekf(model), at_rest(model, 60.0))
    assert not out_of_reach(history).any()
    assert history.std[:, :3].max() < 1.0
    assert history.solved_fraction == 1.0


@pytest.mark.parametrize("degrees_of_freedom", [pytest.param(5, marks=pytest.mark.slow), 6])
def test_a_camera_holds_the_tip(degrees_of_freedom: int) -> None:
    model = pen_model(pen(degrees_of_freedom, SENSORS, **SLOW), ["accel", "gyro", "camera"])
    history = run(Ekf(model), at_rest(model, 60.0))
    assert not out_of_reach(history).any()
    assert history.solved_fraction == 1.0
    tip = history.mean[-1, :3] - POSE[:3]
    assert np.abs(tip / history.std[-1, :3]).max() < 1.0


@pytest.mark.parametrize("name", ESTIMATORS)
def test_back_in_reach_with_the_first_frame(name: str) -> None:
    """The remark is about an estimate, not about a run: a camera's frame takes it back."""
    model = pen_model(pen(6, SENSORS, **SLOW), ["gyro", "camera"])
    recording = at_rest(model, 2.0)
    recording.readings["camera"][:-1] = np.nan
    flags = out_of_reach(run(ESTIMATORS[name](model), recording))
    assert flags[-2]
    assert not flags[-1]


@pytest.mark.parametrize("name", ESTIMATORS)
def test_models_without_a_reach_never_say_so(name: str) -> None:
    """A random walk without readings: σ² = 1 + 9 t. With a reach of 10 it ends at t = 11."""
    model = random_walk_system(2, q=9.0, r=1.0, p0=1.0).model
    nothing = [Measurement(float(t), np.full(2, np.nan)) for t in range(30)]
    assert model.reach is None
    history = run_measurements(ESTIMATORS[name](model), nothing)
    assert history.std[-1] == pytest.approx([np.sqrt(1 + 9 * 29)] * 2, rel=1e-9)
    assert not out_of_reach(history).any()
    for reach, first in (([np.inf, np.inf], 30), ([np.inf, 10.0], 12), ([5.0, 10.0], 3)):
        limited = model.replace(reach=np.array(reach))
        flags = out_of_reach(run_measurements(ESTIMATORS[name](limited), nothing))
        np.testing.assert_array_equal(flags, np.arange(30) >= first)


def test_the_reach_is_one_of_the_tips_and_fits_the_model() -> None:
    config = pen(6, SENSORS, reach_m=0.4)
    model = pen_model(config, ["gyro"])
    assert model.reach is not None
    np.testing.assert_array_equal(model.reach, [0.4] * 3 + [np.inf] * 15)
    with pytest.raises(InputError, match="reach has 3 entries, expected 18"):
        model.replace(reach=np.ones(3))
