"""First readings, and those 0.3 s behind, are linearised where they lead, others at the mean."""

from __future__ import annotations

import dataclasses
from functools import cache

import casadi as ca
import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfState
from estimation.recording import Measurement
from models import attitude
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from tests.engines import compiled_and_interpreted, needs_compiler
from tests.estimation.resting import columns, inertial, model_at_rest
from tests.linear_models import constant_acceleration_system

MODEL = model_at_rest()
SIGMA = [MODEL.state_names.index(f"mrp_{axis}") for axis in "xyz"]
EKF = Ekf(MODEL)
BIASES = [i for i, name in enumerate(MODEL.state_names) if "bias" in name]
SEEDS = 30


@cache
def functions() -> tuple[ca.Function, ca.Function]:
    """Return (σ, turn (3,)) → σ turned, and σ → the body's up direction."""
    sigma, turn = ca.SX.sym("sigma", 3), ca.SX.sym("turn", 3)
    turned = attitude.product(sigma, attitude.exponential(turn))
    up = attitude.body_to_world(sigma)[2, :]
    return ca.Function("turned", [sigma, turn], [turned]), ca.Function("up", [sigma], [up])


def plain(state: EkfState) -> EkfState:
    """Return a state to which no reading is a first one."""
    plain = dataclasses.replace(state, memory=state.memory.copy())
    plain.seen[:] = 1
    return plain


def first_tilts(model: StateSpaceModel, off_rad: float, seed: int) -> tuple[float, float]:
    """Return how far (rad) up is off after the first readings, iterated and plain.

    The start is off by a turn about a random axis, and says so.
    """
    turned, up = functions()
    rng, ekf = np.random.default_rng(seed), EKF
    axis = rng.standard_normal(3)
    x = model.prior.mean.copy()
    x[SIGMA] = turned(x[SIGMA], off_rad * axis / np.linalg.norm(axis)).full().ravel()
    x[BIASES] = model.prior.std[BIASES] * rng.standard_normal(len(BIASES))
    P = model.prior.covariance.copy()
    P[np.ix_(SIGMA, SIGMA)] = off_rad**2 / 3 * np.eye(3)
    y = model.stack(
        {
            s.name: s.h(x).full().ravel() + s.noise_std * rng.standard_normal(s.n_y)
            for s in model.measured_sensors
        }
    )
    start = ekf.init(GaussianState(model.prior.mean, P))
    tilts = []
    for state in (start, plain(start)):
        _, estimate = ekf.step(state, Measurement(0.0, y))
        cosine = up(estimate.state.mean[SIGMA]).full().ravel() @ up(x[SIGMA]).full().ravel()
        tilts.append(float(np.arccos(np.clip(cosine, -1, 1))))
    return tilts[0], tilts[1]


@pytest.mark.parametrize(("off_deg", "within_deg", "plain_deg"), [(60, 10, 20), (120, 8, 40)])
def test_a_start_far_off_finds_up(off_deg: float, within_deg: float, plain_deg: float) -> None:
    """The tip's unknown acceleration and the bias leave some degrees; a plain update, many."""
    tilts = np.degrees([first_tilts(MODEL, np.radians(off_deg), seed) for seed in range(SEEDS)])
    iterated, once = np.percentile(tilts, 95, axis=0)
    assert iterated < within_deg
    assert once > plain_deg


def measured(k: int, *, but: str = "") -> Measurement:
    y = inertial(MODEL, np.zeros(1), k)[0]
    if but:
        y[columns(MODEL, but)] = np.nan
    return Measurement(0.01 * k, y)


def test_each_sensor_has_a_first_reading() -> None:
    ekf = EKF
    state, seen, iterations, settling = ekf.init(), [], [], []
    for measurement in (
        Measurement(-0.01, np.full(MODEL.n_y, np.nan)),
        measured(0, but="accel"),
        measured(1, but="accel"),
        measured(2),
        *(measured(k) for k in range(3, 36)),
    ):
        state, estimate = ekf.step(state, measurement)
        seen.append(state.seen.tolist())
        iterations.append(estimate.iterations)
        settling.append(state.settling_s)
    none, gyro, both = [0.0] * 4, [0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]
    assert seen == [none, gyro, gyro, *[both] * 34]
    assert iterations[:3] == [1, 1, 1]  # a gyroscope is linear
    assert iterations[3] > 1
    assert max(iterations[4:33]) > 1
    assert settling == pytest.approx([0, 0.3, 0.29, *np.arange(0.3, -0.001, -0.01), 0, 0, 0])
    assert iterations[-3:] == [1, 1, 1]


def test_a_linear_update_is_kept_to_the_last_bit() -> None:
    system = constant_acceleration_system(2)
    ekf, start = Ekf(system.model), Ekf(system.model).init()
    y = np.arange(1.0, system.model.n_y + 1)
    _, first = ekf.step(start, Measurement(0.0, y))
    _, once = ekf.step(plain(start), Measurement(0.0, y))
    assert first.iterations == 1
    assert (first.state.mean == once.state.mean).all()
    assert (first.state.covariance == once.state.covariance).all()


def test_the_innovation_is_that_of_the_prediction() -> None:
    ekf, y = EKF, measured(0)
    _, first = ekf.step(ekf.init(), y)
    _, once = ekf.step(plain(ekf.init()), y)
    assert first.iterations > 1
    assert _same(first.innovation, once.innovation)
    assert _same(first.innovation_covariance, once.innovation_covariance)


def _same(a: Array, b: Array) -> bool:
    return bool(((a == b) | (np.isnan(a) & np.isnan(b))).all())


@needs_compiler
def test_compiled_is_interpreted() -> None:
    """At the first readings, while updates settle, and behind."""
    machine, other = compiled_and_interpreted(lambda: Ekf(MODEL))
    for seed in range(5):
        (_, a), (_, b) = (e.step(e.init(), measured(seed)) for e in (machine, other))
        assert a.iterations == b.iterations > 1
        assert (np.abs(a.state.mean - b.state.mean) / a.state.std).max() < 1e-12
    one, two = machine.init(), other.init()
    for k in range(35):
        (one, a), (two, b) = machine.step(one, measured(k)), other.step(two, measured(k))
        assert a.iterations == b.iterations
        assert one.settling_s == two.settling_s
        assert (np.abs(a.state.mean - b.state.mean) / a.state.std).max() < 1e-9
