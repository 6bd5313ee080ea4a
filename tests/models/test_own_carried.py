"""Bounds on process noise and soft constraints, against SciPy's optimum of the same windows."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.recording import Recording
from estimation.status import Status
from models.arrays import Array
from models.errors import InputError
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator, settings_read
from recordings.simulate_pen import simulate_model
from tests.engines import needs_compiler
from tests.references import kalman

WINDOWED = ("mhe-rti", "mhe", "mhe-ipopt")
STEP_S, READ_STD, N = 0.1, 0.05, 14
START = np.array([0.0, 1.0])
START_STD = np.array([0.3, 0.5])
F = np.array([[1.0, STEP_S], [0.0, 1.0]])
G = 0.5 * STEP_S**0.5 * np.array([STEP_S, 1.0])
HORIZON = 5


def cart(**constraints: Any) -> StateSpaceModel:
    """A cart that is pushed at random, seen by a ruler."""

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        kick = 0.5 * ca.sqrt(dt) * w[0]
        return ca.vertcat(x[0] + dt * (x[1] + kick), x[1] + kick)

    return own_model(
        "cart",
        {"position_m": (START[0], START_STD[0]), "velocity_m_s": (START[1], START_STD[1])},
        transition,
        1,
        {"ruler": OwnSensor(lambda x: x[0], {"x": "m"}, READ_STD, 10.0)},
        **constraints,
    )


def readings() -> Array:
    """Of a cart that runs into a wall near 0.5 m, slides into it and comes back."""
    y = 0.9 * np.sin(2.2 * STEP_S * np.arange(N)) + 0.05 * np.cos(19.0 * np.arange(N))
    y[5] = np.nan
    return y


def recording() -> Recording:
    return Recording("cart", STEP_S * np.arange(N), {"ruler": readings()[:, None]})


def history(name: str, model: StateSpaceModel, horizon: int = N) -> EstimateHistory:
    settings = settings_read(name, {"horizon": horizon, "tolerance": 1e-10})
    return run(create_estimator(name, model, **settings), recording())


def rows(mean: Array, P: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return A, b of ‖A z - b‖² of a window, and C: states (n, 2) are C z.

    z holds the first state's deviation in units of its own, and the noises.
    """
    n, L = len(y), np.linalg.cholesky(P)
    C = np.zeros((n, 2, n + 1))
    C[0, :, :2] = L
    offset = [mean]
    for k in range(1, n):
        C[k] = F @ C[k - 1]
        C[k, :, k + 1] += G
        offset.append(F @ offset[-1])
    seen = np.flatnonzero(np.isfinite(y))
    A = np.vstack([np.eye(n + 1), C[seen, 0] / READ_STD])
    b = np.concatenate([np.zeros(n + 1), (y - np.array(offset)[:, 0])[seen] / READ_STD])
    return A, b, np.concatenate([C, np.array(offset)[:, :, None]], axis=2)


def newest(C: Array, z: Array) -> Array:
    found: Array = C[-1] @ np.append(z, 1.0)
    return found


def soft_optimum(y: Array, limit: float, std: float, mean: Array, P: Array) -> Array:
    A, b, C = rows(mean, P, y)

    def residual(z: Array) -> Array:
        position = C[:, 0] @ np.append(z, 1.0)
        return np.concatenate([A @ z - b, np.maximum(position - limit, 0) / std])

    start = np.linalg.lstsq(A, b, rcond=None)[0]
    found = least_squares(residual, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=5000)
    return newest(C, found.x)


def bounded_optimum(y: Array, low: float, high: float, mean: Array, P: Array) -> Array:
    A, b, C = rows(mean, P, y)
    limits = np.full((2, len(y) + 1), [[-np.inf], [np.inf]])
    limits[:, 2:] = [[low], [high]]
    return newest(C, lsq_linear(A, b, limits, method="bvls", tol=1e-15, max_iter=1000).x)


def limited_optimum(y: Array, limit: float, mean: Array, P: Array) -> Array:
    """Return the newest state of a window whose positions stay below a limit, by their dual."""
    A, b, C = rows(mean, P, y)
    inverse = np.linalg.inv(A.T @ A)
    free, slopes = inverse @ A.T @ b, C[:, 0, :-1]
    exceeding = slopes @ free + C[:, 0, -1] - limit
    root = np.linalg.cholesky(slopes @ inverse @ slopes.T + 1e-13 * np.eye(len(y)))
    dual = lsq_linear(
        root.T, np.linalg.solve(root, exceeding), (0, np.inf), method="bvls", tol=1e-15
    )
    return newest(C, free - inverse @ slopes.T @ dual.x)


@cache
def whole(optimum: Callable[..., Array], *limits: float) -> list[Array]:
    """Return the optimum of every window that begins with the first reading."""
    return [optimum(readings()[: n + 1], *limits, *PRIOR) for n in range(N)]


def filtered(n: int) -> tuple[Array, Array]:
    """Return what a filter knows of a state given the readings up to n."""
    P, mean = np.diag(START_STD**2), START
    H, R = np.eye(1, 2), np.array([[READ_STD**2]])
    for k in range(n + 1):
        if k:
            mean, P = kalman.predict(mean, P, F, np.outer(G, G))
        found = kalman.update(mean, P, readings()[[k]], H, R)
        mean, P = found.mean, found.covariance
    return mean, P


def slow(value: Any) -> Any:
    return pytest.param(value, marks=pytest.mark.slow)


@pytest.fixture(params=("compiled", "interpreted"))
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


PAIRS = pytest.mark.parametrize(
    ("engine", "name"),
    [
        *(("compiled", name) for name in WINDOWED),
        *(("interpreted", name) for name in WINDOWED if name != "mhe-ipopt"),
        pytest.param("interpreted", "mhe-ipopt", marks=pytest.mark.slow),
    ],
    indirect=["engine"],
)
"""IPOPT has one engine: of its estimator the filter's stage alone is compiled."""

PRIOR = (START, np.diag(START_STD**2))


@pytest.mark.usefixtures("engine")
@PAIRS
@pytest.mark.parametrize("std", [0.05, slow(1e-3)])
def test_a_soft_limit_is_the_cheapest_compromise(name: str, std: float) -> None:
    found = history(name, cart(soft_constraints={"wall": (lambda x: x[0] - 0.5, std)}))
    wanted = whole(soft_optimum, 0.5, std)
    free = history("ekf", cart())
    assert (np.abs(found.mean[:, :2] - wanted) / free.std).max() < 1e-6
    assert (np.abs(found.mean[:, :2] - free.mean) / free.std).max() > 1
    assert found.mean[:, 0].max() > 0.5
    beyond = np.maximum(found.mean[:, 0] - 0.5, 0) / std
    np.testing.assert_allclose(found.column("wall"), beyond, rtol=0, atol=1e-5)
    assert all(status.is_solved for status in found.status)


@pytest.mark.usefixtures("engine")
@PAIRS
def test_in_windows_that_slide(name: str) -> None:
    """Behind the filter's prior, whose readings no constraint has touched."""
    found = history(name, cart(soft_constraints={"wall": (lambda x: x[0] - 0.5, 0.05)}), HORIZON)
    free, y = history("ekf", cart()), readings()
    for n in range(HORIZON + 1, N):
        mean, P = kalman.predict(*filtered(n - HORIZON - 1), F, np.outer(G, G))
        wanted = soft_optimum(y[n - HORIZON : n + 1], 0.5, 0.05, mean, P)
        assert (np.abs(found.mean[n, :2] - wanted) / free.std[n]).max() < 1e-6


@pytest.mark.usefixtures("engine")
@PAIRS
def test_a_limit_that_hardly_gives_way_is_the_bound(name: str) -> None:
    wanted = np.array(whole(limited_optimum, 0.5))
    free = history("ekf", cart())
    apart = []
    for std in (1e-2, 1e-3, 1e-4):
        found = history(name, cart(soft_constraints={"wall": (lambda x: x[0] - 0.5, std)}))
        apart.append((np.abs(found.mean[:, :2] - wanted) / free.std).max())
    assert apart[0] > 50 * apart[1] > 50 * 50 * apart[2]
    assert apart[2] < 1e-4
    hard = history(name, cart(bounds={"position_m": (None, 0.5)}))
    assert (np.abs(hard.mean - wanted) / free.std).max() < 1e-5


@pytest.mark.usefixtures("engine")
@PAIRS
@pytest.mark.parametrize("bound", [(-0.5, 0.5), slow((0.0, None)), slow((None, -0.3))])
def test_process_noise_stays_within_its_bounds(name: str, bound: Any) -> None:
    found = history(name, cart(noise_bounds={0: bound}))
    low, high = np.array(bound, dtype=float)
    low, high = (-np.inf if np.isnan(low) else low), (np.inf if np.isnan(high) else high)
    wanted = whole(bounded_optimum, low, high)
    free = history("ekf", cart())
    assert (np.abs(found.mean[:, :2] - wanted) / free.std).max() < 1e-6
    assert (np.abs(found.mean[:, :2] - free.mean) / free.std).max() > 0.5
    assert (found.column("noise_0") >= low - 1e-9).all()
    assert (found.column("noise_0") <= high + 1e-9).all()
    assert all(status.is_solved for status in found.status)


@pytest.mark.usefixtures("engine")
@PAIRS
def test_the_noise_that_led_to_a_window_stays_within_them_too(name: str) -> None:
    found = history(name, cart(noise_bounds={0: (-0.5, 0.5)}), HORIZON)
    free, y = history("ekf", cart()), readings()
    for n in range(HORIZON + 1, N):
        start = n - HORIZON - 1
        behind = np.concatenate([[np.nan], y[start + 1 : n + 1]])
        wanted = bounded_optimum(behind, -0.5, 0.5, *filtered(start))
        assert (np.abs(found.mean[n, :2] - wanted) / free.std[n]).max() < 1e-6


BOTH: dict[str, Any] = {
    "noise_bounds": {0: (-0.5, 0.5)},
    "soft_constraints": {"wall": (lambda x: x[0] - 0.5, 0.05)},
}


@pytest.mark.usefixtures("engine")
def test_a_kalman_filter_obeys_neither() -> None:
    found, free = history("ekf", cart(**BOTH)), history("ekf", cart())
    np.testing.assert_allclose(found.mean[:, :2], free.mean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.std[:, :2], free.std, rtol=1e-12)
    assert found.state_names == ("position_m", "velocity_m_s", "noise_0", "wall")
    assert np.abs(found.column("wall")).max() == 0


@needs_compiler
def test_the_export_obeys_both() -> None:
    model = cart(**BOTH)
    exported = Exported(export_texts(exportable("mhe-rti", model, horizon=HORIZON), "double"))
    theirs = run_measurements(exported, recording().measurements(model))
    ours = run(create_estimator("mhe-rti", model, horizon=HORIZON), recording())
    assert (np.abs(theirs.mean - ours.mean) / ours.std).max() < 1e-9
    assert ours.column("noise_0").min() == pytest.approx(-0.5, abs=1e-9)


def test_two_readings_of_one_instant_share_noise_and_slack() -> None:
    """A step of Δt = 0 changes nothing."""
    model = cart(**BOTH)
    x = np.array([0.4, 1.0, 0.3, -0.2])
    assert model.f(x, [0.7, 0.9], 0.0).full().ravel().tolist() == x.tolist()
    assert model.f(x, [0.7, 0.9], 0.1).full().ravel()[2:].tolist() == [0.7, 0.9]


@pytest.mark.parametrize(
    ("constraints", "sentence"),
    [
        ({"noise_bounds": {1: (0, 1)}}, "bound on noise 1, expected a number from 0 to 0"),
        ({"noise_bounds": {"w": (0, 1)}}, "bound on noise 'w', expected a number from 0 to 0"),
        ({"noise_bounds": {0: (1, 0)}}, "bound on noise_0: lower 1.0 is not below upper 0.0"),
        ({"soft_constraints": {"position_m": (lambda x: x[0], 1)}}, "'position_m' is the name of"),
        ({"soft_constraints": {"ruler": (lambda x: x[0], 1)}}, "'ruler' is the name of another"),
        ({"soft_constraints": {"wall": (lambda x: x[0], 0)}}, "wall is .* positive deviation"),
        ({"soft_constraints": {"wall": 3.0}}, r"wall is 3.0, expected \(function of the states"),
        (
            {"soft_constraints": {"wall": (lambda x: x, 1)}},
            r"wall has shape \(2, 1\), expected one",
        ),
    ],
)
def test_what_does_not_fit_is_refused(constraints: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        cart(**constraints)


@pytest.mark.slow
@pytest.mark.parametrize("std", [0.1, 1e-3, 1e-6])
def test_a_curved_limit_is_what_ipopt_makes_of_it(std: float) -> None:
    """On a pendulum, whose energy should stay low; with a bounded push."""

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
        rate = x[1] - 9.0 * dt * ca.sin(x[0]) + 0.5 * ca.sqrt(dt) * w[0]
        return ca.vertcat(x[0] + dt * rate, rate)

    model = own_model(
        "pendulum",
        {"angle_rad": (0.8, 0.5), "rate_rad_s": (0.0, 1.0)},
        transition,
        1,
        {"shadow": OwnSensor(lambda x: ca.sin(x[0]), {"x": "m"}, 0.05, 20.0)},
        noise_bounds={0: (-1, 1)},
        soft_constraints={"energy": (lambda x: x[0] ** 2 + 0.1 * x[1] ** 2 - 0.25, std)},
    )
    given = simulate_model(model, duration_s=2.0, seed=1)
    ours, theirs = (run(create_estimator(name, model), given) for name in ("mhe", "mhe-ipopt"))
    assert set(ours.status) == set(theirs.status) == {Status.SOLVED}
    assert (np.abs(ours.mean - theirs.mean) / ours.std).max() < 1e-6
    assert ours.column("energy").max() > 1e-9
