"""The truth of a simulation: instants, states drawn from a model, biases that walk."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.errors import InputError
from models.free_pen import SIGMA
from models.motions import sample_motion
from models.pen import pen_model
from models.random_streams import seed_sequence, stream
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.writing_area import WritingArea
from models.simulation import (
    arrival_times,
    drawn_states,
    sample_times,
    states_along,
    true_states,
    union_of_times,
)
from models.state_space import StateSpaceModel
from tests.linear_models import LinearSystem, coupled_system, random_walk_system
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE, Array, pen
from tests.references.allan import allan_variance, relative_error, walk_kernel

WALK = 0.02
BIASED: dict[str, Any] = {
    **ACCELEROMETER,
    "bias_std_m_s2": 0.3,
    "bias_walk_m_s2_per_sqrt_s": WALK,
    "rate_hz": 100.0,
}
CAMERA_30: dict[str, Any] = {**CAMERA, "rate_hz": 30.0, "delay_s": 0.045}
STANDARD_ERRORS = 4.0
"""Statistical limits; a right simulator exceeds one of a hundred with probability 0.6 %."""


def biased_model(**others: Any) -> StateSpaceModel:
    return pen_model(pen(6, {"accel": Accelerometer(**BIASED), **others}))


def biases(model: StateSpaceModel, times: dict[str, Array], seed: int) -> tuple[Array, Array]:
    """Return all instants and the accelerometer's biases (n, 3) along a pen held still."""
    time_s = union_of_times(times)
    states = true_states(model, sample_motion("still", time_s), seed, times=times)
    index = [model.state_names.index(name) for name in model.sensor("accel").bias_states]
    return time_s, states[:, index]


def test_instants_are_exact_over_an_hour() -> None:
    model = pen_model(
        pen(
            6,
            {
                "a": Accelerometer(**ACCELEROMETER, rate_hz=118.8),
                "g": Gyroscope(**GYROSCOPE, rate_hz=100.0),
                "c": PoseCamera(**CAMERA, rate_hz=30.0),
            },
        )
    )
    times = sample_times(model, 3600.0)
    for name, rate in (("a", Fraction(1188, 10)), ("g", Fraction(100)), ("c", Fraction(30))):
        assert len(times[name]) == int(3600 * rate) + 1
        for k in [0, 1, 2, *range(7, len(times[name]), 997), len(times[name]) - 1]:
            assert abs(Fraction(times[name][k]) - k / rate) < Fraction(1, 10**9)
    times = {name: at[at < 30] for name, at in times.items()}
    union = union_of_times(times)
    assert set(union) == set().union(*(set(at) for at in times.values()))
    assert (np.diff(union) > 0).all()


def test_samples_arrive_their_delay_later() -> None:
    model = biased_model(camera=PoseCamera(**CAMERA_30))
    times = sample_times(model, 60.0)
    arrivals = arrival_times(model, times)
    np.testing.assert_array_equal(arrivals["accel"], times["accel"])
    np.testing.assert_allclose(arrivals["camera"] - times["camera"], 0.045, rtol=0, atol=1e-9)


def test_a_sensor_without_readings_has_no_instants() -> None:
    times = sample_times(biased_model(area=WritingArea()), 1.0)
    assert set(times) == {"accel"}


def test_a_stream_is_of_its_purpose_and_seed() -> None:
    root = seed_sequence(7)
    first = stream(root, "noise of gyro").random(5)
    stream(root, "noise of accel").random(100)
    np.testing.assert_array_equal(first, stream(root, "noise of gyro").random(5))
    for other in (stream(root, "noise of gyr"), stream(seed_sequence(8), "noise of gyro")):
        assert np.abs(other.random(5) - first).max() > 1e-3
    # A generator gives a new set of streams at every call.
    rng = np.random.default_rng(7)
    assert seed_sequence(rng).entropy != seed_sequence(rng).entropy
    assert seed_sequence(root) is root


@pytest.mark.parametrize("system", [coupled_system(3), random_walk_system(2, 0.5, 1.0, 2.0)])
def test_drawn_states_have_the_models_law(system: LinearSystem) -> None:
    """Whitened by the exact covariance at each of three instants, independent unit normals."""
    model, n = system.model, 2000
    times = np.array([0.0, 0.3, 0.35])
    rng = np.random.default_rng(11)
    drawn = np.array([drawn_states(model, times, rng) for _ in range(n)])
    mean, P = model.prior.mean, model.prior.covariance
    for k in range(3):
        if k:
            dt = times[k] - times[k - 1]
            mean, P = system.F(dt) @ mean, system.F(dt) @ P @ system.F(dt).T + system.Q(dt)
        z = np.linalg.solve(np.linalg.cholesky(P), (drawn[:, k] - mean).T)
        assert np.abs(z.mean(axis=1)).max() < STANDARD_ERRORS / np.sqrt(n)
        covariance = z @ z.T / n
        error = np.abs(covariance - np.eye(model.n_x)) * np.sqrt(n / (1 + np.eye(model.n_x)))
        assert error.max() < STANDARD_ERRORS


def test_drawn_steps_are_independent() -> None:
    """The steps of a walk over 20000 instants: no correlation at any short lag."""
    model = random_walk_system(1, 0.5, 1.0, 2.0).model
    states = drawn_states(model, np.arange(20001) * 0.01, np.random.default_rng(5))
    steps = np.diff(states[:, 0]) / np.sqrt(0.5 * 0.01)
    n = len(steps)
    assert abs(np.mean(steps**2) - 1) < STANDARD_ERRORS * np.sqrt(2 / n)
    for lag in range(1, 10):
        assert abs(np.mean(steps[lag:] * steps[:-lag])) < STANDARD_ERRORS / np.sqrt(n)


def drawn_starts(degrees_of_freedom: int) -> tuple[StateSpaceModel, Array]:
    """Return the first states (20, n_x) of as many draws about an azimuth of 3.1 rad."""
    sensors = {"accel": Accelerometer(**BIASED)}
    model = pen_model(pen(degrees_of_freedom, sensors, prior={"azimuth_rad": 3.1}))
    draws = [drawn_states(model, np.zeros(1), np.random.default_rng(seed))[0] for seed in range(20)]
    return model, np.array(draws)


def test_a_drawn_start_is_on_the_manifold() -> None:
    model, starts = drawn_starts(5)
    azimuth = starts[:, model.state_names.index("azimuth_rad")]
    assert np.abs(azimuth).max() <= np.pi
    assert azimuth.min() < -1 < 1 < azimuth.max()


def test_a_drawn_start_of_the_free_pen_is_on_the_manifold() -> None:
    model, starts = drawn_starts(6)
    assert np.linalg.norm(starts[:, SIGMA], axis=1).max() <= 1 + 1e-15
    assert model.outputs is not None
    azimuth = model.outputs.function(starts.T).full()[model.outputs.names.index("azimuth_rad")]
    assert np.abs(azimuth).max() <= np.pi
    assert azimuth.min() < -1 < 1 < azimuth.max()
    axes = Rotation.from_mrp(starts[:, SIGMA]).apply([0, 0, 1])
    np.testing.assert_allclose(azimuth, np.arctan2(axes[:, 1], axes[:, 0]), rtol=0, atol=1e-13)


def test_further_states_leave_a_drawn_motion() -> None:
    """A bias is appended to the state: the pen moves as before."""
    time_s = np.arange(50) * 0.01
    plain = pen_model(pen(6, {"accel": Accelerometer(**ACCELEROMETER)}))
    drawn = [drawn_states(m, time_s, np.random.default_rng(3)) for m in (plain, biased_model())]
    assert drawn[1].shape == (50, 21)
    np.testing.assert_array_equal(drawn[0], drawn[1][:, :18])


@pytest.mark.parametrize("m", [10, 30, 100, 300, 1000])
def test_allan_deviation_of_the_bias_walk(m: int) -> None:
    """K √(τ/3) for three axes over 300 s; 1/2m² is the discreteness of the clusters."""
    model = biased_model()
    times = sample_times(model, 300.0)
    _, walk = biases(model, times, seed=4)
    n, tau = len(walk), m / 100.0
    expected = WALK * np.sqrt(tau / 3 * (1 + 1 / (2 * m**2)))
    found = np.sqrt(np.mean([allan_variance(axis, m) for axis in walk.T]))
    # Half the relative error of the variance; three independent axes.
    limit = STANDARD_ERRORS * relative_error(walk_kernel(m), m, n) / 2 / np.sqrt(3)
    assert abs(found / expected - 1) < limit
    assert limit < 0.5


def test_biases_walk_as_the_model_says() -> None:
    model = biased_model()
    for k, name in enumerate(model.sensor("accel").bias_states):
        row = model.state_names.index(name)
        for dt in (0.01, 2.0):
            w = np.zeros(model.n_w)
            w[18 + k] = 1.0
            step = float(model.f(np.zeros(model.n_x), w, dt)[row])
            assert model.sensor("accel").bias_walk * np.sqrt(dt) == pytest.approx(step, rel=1e-14)


def test_biases_start_from_the_prior() -> None:
    model, n = biased_model(), 400
    times = {"accel": np.zeros(1)}
    starts = np.array([biases(model, times, seed)[1][0] for seed in range(n)]) / 0.3
    assert np.abs(np.mean(starts**2, axis=0) - 1).max() < STANDARD_ERRORS * np.sqrt(2 / n)
    assert np.abs(starts.mean(axis=0)).max() < STANDARD_ERRORS / np.sqrt(n)


def test_further_instants_refine_a_bias_walk() -> None:
    """The walk stays at the sensor's instants, and all its steps have the law of a walk."""
    model = biased_model(camera=PoseCamera(**CAMERA_30))
    times = sample_times(model, 100.0)
    coarse_s, coarse = biases(biased_model(), {"accel": times["accel"]}, seed=9)
    fine_s, fine = biases(model, times, seed=9)
    assert len(fine_s) == 10001 + 2000
    np.testing.assert_array_equal(fine[np.searchsorted(fine_s, coarse_s)], coarse)
    steps = np.diff(fine, axis=0) / (WALK * np.sqrt(np.diff(fine_s)))[:, None]
    n = steps.size
    assert abs(np.mean(steps**2) - 1) < STANDARD_ERRORS * np.sqrt(2 / n)
    assert abs(np.mean(steps[1:] * steps[:-1])) < STANDARD_ERRORS / np.sqrt(n)
    # Next to an instant in between: there a chord alone would be too short.
    inside = ~np.isin(fine_s[1:], coarse_s)
    for near in (steps[inside], steps[1:][inside[:-1]]):
        assert abs(np.mean(near**2) - 1) < STANDARD_ERRORS * np.sqrt(2 / near.size)


def test_a_state_that_nothing_moves_is_refused() -> None:
    model = coupled_system(1).model
    with pytest.raises(InputError, match=r"motion does not say what s1_m does, expected .*s0_m"):
        states_along(model, np.zeros(1), {"s0_m": np.zeros(1)}, 0, {})
