"""A free pen turned through every attitude: finite, positive definite, right to 3 deviations.

Its paths pass exactly upright, exactly upside down and over the switch to the shadow, |σ| = 1, in
the middle of a run, so that every window has them inside for a while. SciPy gives the truth; the
model's sensors read it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimation.estimator import run_measurements
from estimation.history import EstimateHistory
from estimation.recording import Recording, Truth
from estimation.status import REGULARITY_LIMIT, Status
from models.arrays import Array
from models.free_pen import SIGMA, STATES
from models.gaussian import GaussianState
from models.motion import Motion, TipBoundedVelocity, white_jerk_motion
from models.pen import pen_model
from models.pen_file import load_pen
from models.simulation import sample_times, simulate_readings, states_along, union_of_times
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator, settings_read
from tests.references.free_tangent import heading_of

MIDDLE_S, END_S = 0.4, 0.8
"""When a path is where it is named after; how long it goes on."""
HORIZON = 8
UPSIDE_DOWN = Rotation.from_rotvec([np.pi, 0.0, 0.0])
PATHS: dict[str, tuple[Rotation, tuple[float, float, float]]] = {
    "upright, head over heels": (Rotation.identity(), (3.5, 0.0, 0.0)),
    "upright, askew": (Rotation.from_rotvec([0.0, 0.0, 2.0]), (2.0, -1.5, 2.5)),
    "upside down": (UPSIDE_DOWN, (-1.0, 3.0, 0.5)),
    "upside down, spinning": (UPSIDE_DOWN, (0.2, 0.1, 4.0)),
    "the shadow, lying": (Rotation.from_rotvec(np.pi * np.array([0.6, 0.0, 0.8])), (1.0, 2.0, 3.0)),
    "the shadow, along it": (
        Rotation.from_rotvec(np.pi * np.array([0.6, 0.0, 0.8])),
        (2.4, 0.0, 3.2),
    ),
}
"""Name → attitude in the middle, and the body's rate, which is constant (rad/s)."""

CHOICES = {"gyro": ("accel", "gyro"), "camera": ("accel", "gyro", "camera")}
ESTIMATORS = ("ekf", "mhe-rti", "mhe", "mhe-ipopt")
QUICK = {"ekf", "mhe-rti"}
SIGNIFICANT = 3.0


@cache
def model_of(choice: str) -> StateSpaceModel:
    """The reference pen in a hand that turns briskly; its tip stays on the desk."""
    motion = Motion(
        tip=TipBoundedVelocity(speed_m_s=0.05, correlation_time_s=0.1),
        attitude=white_jerk_motion(1.0, 20.0).attitude,
    )
    pen = load_pen("reference").model_copy(update={"motion": motion})
    return pen_model(pen, CHOICES[choice])


def path_of(name: str, time_s: Array) -> dict[str, Array]:
    """Name of a state → its values (n,)."""
    middle, rate = PATHS[name]
    R = middle * Rotation.from_rotvec(np.outer(time_s - MIDDLE_S, rate))
    path = {state: np.zeros(len(time_s)) for state, _ in STATES}
    for axis, sigma, omega in zip("xyz", R.as_mrp().T, rate, strict=True):
        path[f"mrp_{axis}"] = sigma
        path[f"body_rate_{axis}_rad_s"] = np.full(len(time_s), omega)
    return path


@cache
def recorded(name: str, choice: str, seed: int) -> Recording:
    model, root = model_of(choice), np.random.SeedSequence(seed)
    times = sample_times(model, END_S)
    time_s = union_of_times(times)
    states = states_along(model, time_s, path_of(name, time_s), root, times)
    readings = simulate_readings(model, times, time_s, states, root).sensors
    return Recording.from_sensors(name, readings, truth=Truth(time_s, model.state_names, states))


@cache
def first_known(name: str, choice: str, seed: int) -> GaussianState:
    """A start about the truth: 6° wrong per axis, rates by 0.3 rad/s, and told so."""
    model, truth = model_of(choice), recorded(name, choice, seed).truth
    assert truth is not None
    std = model.prior.std.copy()
    std[SIGMA] = np.deg2rad(6.0)
    for k, state in enumerate(model.state_names):
        if state.startswith("body_rate"):
            std[k] = 0.3
        if state.startswith("body_acceleration"):
            std[k] = 2.0
        if state.startswith("tip") and not state.endswith("s2"):
            std[k] = 0.01
    wrong = std * np.random.default_rng(seed).standard_normal(model.n_x)
    wrong[18:] = 0.0  # biases were drawn from the prior: it stays as it is
    mean = np.asarray(model.retract(truth.values[0], wrong)).ravel()
    mean[18:] = model.prior.mean[18:]
    return GaussianState(mean, np.diag(std**2))


def run(estimator: str, name: str, choice: str, seed: int) -> EstimateHistory:
    model = model_of(choice)
    built = create_estimator(estimator, model, **settings_read(estimator, {"horizon": HORIZON}))
    measurements = list(recorded(name, choice, seed).measurements(model))
    prior = first_known(name, choice, seed)
    return run_measurements(built, measurements, prior=prior, covariances=True)


def attitude_deviations(history: EstimateHistory, truth: Truth, model: StateSpaceModel) -> Array:
    """Errors of the attitude (n, 3) along the axes of its covariance, in standard deviations."""
    states = truth.states(model.state_names, history.time_s)
    true, found = (Rotation.from_mrp(x[:, SIGMA]) for x in (states, history.mean))
    turns = heading_of(found).inv().apply((true * found.inv()).as_rotvec())
    lengths, axes = np.linalg.eigh(history.covariance[:, SIGMA, SIGMA])
    return np.asarray(np.einsum("nij,ni->nj", axes, turns) / np.sqrt(lengths))


def check(estimator: str, name: str, choice: str, seed: int = 1) -> None:
    model, history = model_of(choice), run(estimator, name, choice, seed)
    truth = recorded(name, choice, seed).truth
    assert truth is not None
    assert len(history) > 70
    for values in (history.mean, history.covariance, history.values, history.values_std):
        assert np.isfinite(values).all()
    correlation = history.covariance / (history.std[:, :, None] * history.std[:, None, :])
    assert np.linalg.eigvalsh(correlation).min() > 1e-9
    trouble = Status.SOLVER_FAILED | Status.NOT_FINITE | Status.INFEASIBLE
    assert not any(status & trouble for status in history.status)
    away = np.abs(attitude_deviations(history, truth, model))
    assert np.median(away) < 1.5
    assert (away < SIGNIFICANT).mean() >= 0.97
    assert away.max() < SIGNIFICANT + 1.0
    for axis in "xyz":
        rate = f"body_rate_{axis}_rad_s"
        true = truth.states((rate,), history.time_s)[:, 0]
        wrong = np.abs(history.column(rate) - true) / history.std_of(rate)
        assert (wrong < SIGNIFICANT).mean() >= 0.97


def test_the_paths_go_where_they_are_said_to_go() -> None:
    """Upright, upside down and at the shadow's switch at an instant; the switch is crossed."""
    around = MIDDLE_S + np.array([-0.01, 0.0, 0.01])
    for name in PATHS:
        path = path_of(name, around)
        sigma = np.column_stack([path[f"mrp_{axis}"] for axis in "xyz"])
        level = np.linalg.norm(Rotation.from_mrp(sigma[1]).apply([0, 0, 1])[:2])
        height = Rotation.from_mrp(sigma[1]).apply([0, 0, 1])[2]
        if name.startswith("upright"):
            assert (level, height) == pytest.approx((0, 1), abs=1e-15)
        if name.startswith("upside down"):
            assert (level, height) == pytest.approx((0, -1), abs=1e-15)
        if name != "upright, head over heels" and not name.startswith("upright"):
            assert np.linalg.norm(sigma[1]) == pytest.approx(1, abs=1e-12)
    crossed = path_of("the shadow, along it", around)
    sigma = np.column_stack([crossed[f"mrp_{axis}"] for axis in "xyz"])
    assert sigma[0] @ sigma[2] < -0.9
    through = path_of("upright, head over heels", np.linspace(0, END_S + 0.6, 200))
    assert np.linalg.norm(np.diff(through["mrp_x"])[None], axis=0).max() > 1.5


@pytest.mark.cover
@pytest.mark.parametrize("choice", CHOICES)
@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize(
    "estimator",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in ESTIMATORS],
)
def test_through_every_attitude(estimator: str, name: str, choice: str) -> None:
    check(estimator, name, choice)


@pytest.mark.slow
@pytest.mark.parametrize("choice", CHOICES)
@pytest.mark.parametrize("seed", range(2, 6))
def test_the_filters_with_other_noise(seed: int, choice: str) -> None:
    for estimator in sorted(QUICK):
        for name in PATHS:
            check(estimator, name, choice, seed)


@pytest.mark.parametrize("name", PATHS)
def test_what_is_read_stays_the_attitude(name: str) -> None:
    """Angles and quaternion of every step are the rotation of the state, upright too."""
    history = run("ekf", name, "gyro", 1)
    R = Rotation.from_mrp(history.mean[:, SIGMA])
    quaternion = np.column_stack([history.column(f"attitude_{axis}") for axis in "xyzw"])
    assert quaternion == pytest.approx(R.as_quat(canonical=True), abs=1e-12)
    axes = R.apply([0, 0, 1])
    assert np.sin(history.column("elevation_rad")) == pytest.approx(axes[:, 2], abs=1e-12)
    azimuth = history.column("azimuth_rad")
    level = np.cos(history.column("elevation_rad"))
    heading = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth)])
    assert heading == pytest.approx(axes[:, :2], abs=1e-12)
    if name.startswith("up"):
        assert history.std_of("azimuth_rad").max() > 3 * history.std_of("elevation_rad").max()
    singular = np.array([Status.NEAR_SINGULAR in status for status in history.status])
    assert np.array_equal(singular, np.linalg.norm(axes[:, :2], axis=1) < REGULARITY_LIMIT)
    if name == "upside down, spinning":  # others may pass it between two samples
        assert singular.any()
    assert history.std_of("azimuth_rad").max() <= np.pi / np.sqrt(3) + 1e-12
