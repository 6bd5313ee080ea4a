"""A watched estimator says what is wrong with its sensors, and goes on without them meanwhile."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from ekf_baseline import Ekf
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Recording
from estimation.status import Status
from estimation.watch.config import WatchConfig
from estimation.watch.flags import Flag
from estimation.watch.watched import Watched
from models.arrays import Array
from models.errors import InputError
from models.gentle_hand import at_speed, bounded_writing
from models.linear_models import linear_model
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate, simulate_model

SENSORS = ("accel", "gyro", "camera")
AT_S = 3.0


@cache
def pen() -> PenConfig:
    prior = load_pen("reference").prior.model_copy(update=at_speed("prior"))
    return load_pen("reference").model_copy(update={"motion": bounded_writing(), "prior": prior})


@cache
def model() -> StateSpaceModel:
    return pen_model(pen(), SENSORS)


@cache
def watched(on_lost: str = "restart") -> Watched:
    return Watched(Ekf(model()), WatchConfig(on_lost=on_lost))


@cache
def clean(duration_s: float = 7.0, speed: float = 1.0) -> Recording:
    return simulate(
        pen(), SENSORS, motion="handwriting", duration_s=duration_s, seed=4, speed=speed
    )


def changed(sensor: str, for_s: float, change: Callable[[Array], Array]) -> Recording:
    """Return the recording with readings of a sensor changed, (n, n_y), for a while."""
    readings = dict(clean().readings)
    values, time_s = readings[sensor].copy(), clean().time_s
    hit = (time_s >= AT_S) & (time_s < AT_S + for_s) & ~np.isnan(values[:, 0])
    values[hit] = change(values[hit])
    return dataclasses.replace(clean(), readings={**readings, sensor: values})


def said(history: EstimateHistory, sensor: str, flag: Flag) -> Array:
    """Return the instants at which something is said of a sensor."""
    flags = history.flagged[:, history.sensor_names.index(sensor)]
    return history.time_s[(flags & flag) != 0]


def worst(history: EstimateHistory, from_s: float) -> float:
    """Return the largest error of the attitude from an instant on, deg."""
    names = ("azimuth_rad", "elevation_rad", "spin_rad")
    assert clean().truth is not None
    errors = history.errors(clean().truth)[:, [history.names.index(name) for name in names]]
    return float(np.degrees(np.abs(errors[history.time_s >= from_s]).max()))


def test_a_clean_stream_is_not_flagged_and_estimated_as_without_a_watch() -> None:
    bare, history = run(Ekf(model()), clean()), run(watched(), clean())
    assert not history.flagged.any()
    assert set(history.status) == set(bare.status)
    for name in ("mean", "std", "innovation", "derived"):
        np.testing.assert_array_equal(getattr(history, name), getattr(bare, name))


def test_many_at_once_are_as_many_steps() -> None:
    recording = changed("gyro", 0.5, lambda values: values * [-1, 1, 1]).first(4.5)
    together = run(watched(), recording)
    apart = run_measurements(watched(), recording.measurements(model()))
    assert together.flagged.any()
    np.testing.assert_array_equal(together.flagged, apart.flagged)
    assert together.status == apart.status
    np.testing.assert_array_equal(together.mean, apart.mean)
    np.testing.assert_array_equal(together.std, apart.std)


def test_a_sensor_that_is_stuck_is_said_and_not_used() -> None:
    history = run(
        watched(), changed("gyro", 1.0, lambda values: np.tile(values[:1], (len(values), 1)))
    )
    stuck = said(history, "gyro", Flag.STUCK)
    assert AT_S < stuck[0] < AT_S + 0.05
    assert stuck[-1] < AT_S + 1.0
    assert worst(history, AT_S) < 3.0
    assert not said(history, "camera", Flag.STUCK).size


def test_a_spike_is_as_good_as_no_reading() -> None:
    def spike(values: Array) -> Array:
        values[0, 1] += 2.0
        return values

    def nothing(values: Array) -> Array:
        values[0] = np.nan
        return values

    history = run(watched(), changed("gyro", 0.1, spike))
    assert said(history, "gyro", Flag.OUTLIER).tolist() == [AT_S]
    without = run(watched(), changed("gyro", 0.1, nothing))
    np.testing.assert_array_equal(history.mean, without.mean)


def test_a_sensor_that_lies_is_left_out_and_taken_back() -> None:
    history = run(watched(), changed("gyro", 1.0, lambda values: values * [-1, 1, 1]))
    doubted, out = (said(history, "gyro", flag) for flag in (Flag.INCONSISTENT, Flag.LEFT_OUT))
    assert AT_S < doubted[0] < AT_S + 0.2
    assert AT_S < out[0] < AT_S + 1.0
    assert AT_S + 1.0 < out[-1] < AT_S + 3.0
    assert not said(history, "camera", Flag.LEFT_OUT).size
    assert worst(history, AT_S + 3.5) < 1.5


def test_a_pose_that_mirrors_leaves_the_camera_out() -> None:
    history = run(watched(), changed("camera", 1.0, lambda values: values * [1, 1, 1, -1, -1, -1]))
    assert said(history, "camera", Flag.LEFT_OUT).size
    assert not said(history, "gyro", Flag.LEFT_OUT).size
    assert worst(history, AT_S) < 3.0


def test_a_bias_that_steps_is_followed() -> None:
    history = run(watched(), changed("gyro", 99.0, lambda values: values + np.array([0.15, 0, 0])))
    assert said(history, "gyro", Flag.INCONSISTENT).size
    bias = history.column("gyro_bias_x_rad_s")
    before = bias[history.time_s < AT_S][-1]
    assert bias[-1] - before == pytest.approx(0.15, abs=0.03)


@pytest.mark.parametrize("on_lost", ["restart", "hold"])
def test_a_hole_loses_the_attitude_and_it_is_found(on_lost: str) -> None:
    kept = (clean().time_s < AT_S) | (clean().time_s > AT_S + 2.0)
    recording = dataclasses.replace(
        clean(),
        time_s=clean().time_s[kept],
        readings={name: values[kept] for name, values in clean().readings.items()},
        arrivals={name: values[kept] for name, values in clean().arrivals.items()},
    )
    history = run(watched(on_lost), recording)
    lost = history.time_s[[Status.LOST in status for status in history.status]]
    assert len(lost), "it says when"
    assert AT_S + 2.0 < lost[0] < AT_S + 2.1
    assert not Status.LOST.is_solved
    if on_lost == "restart":
        assert lost[-1] < AT_S + 2.5
        assert worst(history, AT_S + 3.0) < 2.0
    else:
        np.testing.assert_array_equal(history.mean[:300], run(Ekf(model()), recording).mean[:300])


def test_a_brisker_hand_is_livelier_and_no_sensor_blamed() -> None:
    history = run(watched(), clean(4.0, 3.0))
    assert not history.flagged.any()
    late = [
        Status.LIVELIER in s for s, t in zip(history.status, history.time_s, strict=True) if t > 1
    ]
    assert all(late)


def test_a_model_of_ones_own() -> None:
    own = linear_model(
        "cart",
        A=[[1, 0.1], [0, 1]],
        C=np.eye(2),
        Q=np.diag([1e-4, 1e-3]),
        R=0.01,
        prior=((0.0, 0.0), 1.0),
        dt_s=0.1,
    )
    estimator = Watched(Ekf(own))
    recording = simulate_model(own, duration_s=60.0, seed=2)
    bare, history = run(Ekf(own), recording), run(estimator, recording)
    assert not history.flagged.any()
    np.testing.assert_array_equal(history.mean, bare.mean)
    name = own.sensors[0].name
    readings = {key: values.copy() for key, values in recording.readings.items()}
    readings[name][300] += 5.0
    spiked = run(estimator, dataclasses.replace(recording, readings=readings))
    assert said(spiked, name, Flag.OUTLIER).tolist() == [recording.time_s[300]]


def test_settings_are_checked() -> None:
    with pytest.raises(InputError, match="on_lost"):
        WatchConfig(on_lost="restrat")
    for settings in ({"replay_s": 0.0}, {"deadline_s": -1.0}):
        with pytest.raises(InputError, match="positive time"):
            WatchConfig(**settings)  # type: ignore[arg-type]
