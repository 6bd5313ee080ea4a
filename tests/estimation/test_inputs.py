"""Known inputs: a known force is the Kalman filter's with it, whatever the estimator and engine."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import least_squares

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from estimation.estimator import run, run_measurements
from estimation.inputs import all_with_inputs
from estimation.recording import Measurement, Recording
from estimation.status import Status
from mhe.config import MheConfig
from mhe.realtime import Mhe
from mhe.reference.ipopt import MheIpopt
from mhe.sparse_qp.sequential_qp import SequentialQp
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.errors import InputError
from models.own_models import OwnSensor, own_model
from models.state_space import StateSpaceModel
from pen_mhe.estimators import LEAST_SQUARES, create_estimator, settings_read
from recordings.formats.model_tables import (
    recording_from_model_table,
    recording_to_model_table,
)
from recordings.formats.tables import write_table
from recordings.read import read_recording
from recordings.simulate_pen import simulate_model
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation.lamps import lamp, swung
from tests.pages import run_python
from tests.references import kalman

PAGE = Path(__file__).resolve().parents[2] / "docs" / "inputs.md"
STEP_S, N = 0.05, 9
A, B = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[0.0], [1.0]])
SHORT: dict[str, Any] = {"horizon": N}


def spring(**interpolated: Any) -> StateSpaceModel:
    """The damped spring of CasADi's example: a force is known, and held or interpolated."""

    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, u: ca.SX) -> ca.SX:
        def rate(x: ca.SX) -> ca.SX:
            return ca.vertcat(x[1], -x[0] - 0.5 * x[1] + u[0] + 0.1 * w[0])

        k1 = rate(x)
        k2 = rate(x + dt / 2 * k1)
        k3 = rate(x + dt / 2 * k2)
        k4 = rate(x + dt * k3)
        return x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    states = {"position_m": (1.0, 0.01), "velocity_m_s": (0.0, 0.01)}
    ruler = OwnSensor(lambda x: x[0], {"x": "m"}, 0.005, 20.0)
    inputs = {"force_n": "N"}
    return own_model(
        "spring", states, transition, 1, {"ruler": ruler}, inputs=inputs, **interpolated
    )


def force(time_s: Array) -> Array:
    return np.where(time_s < 2, np.cos(time_s), 0.0)


def filtered(model: StateSpaceModel, y: Array, u: Array) -> tuple[Array, Array]:
    """Return means and deviations (n, 2) of the textbook's filter; u[k] acts behind instant k."""
    powers, F, G = np.eye(2), np.eye(2), np.zeros((2, 2))
    for i in range(1, 5):  # a Runge-Kutta step of order 4 is the series up to order 4
        G = G + powers * STEP_S**i / float(np.prod(range(1, i + 1)))
        powers = powers @ A
        F = F + powers * STEP_S**i / float(np.prod(range(1, i + 1)))
    Q, H, R = 0.01 * (G @ B) @ (G @ B).T, np.array([[1.0, 0.0]]), np.array([[0.005**2]])
    mean, P, means, stds = model.prior.mean, model.prior.covariance, [], []
    for k in range(len(y)):
        if k:
            mean, P = kalman.predict(mean, P, F, Q)
            mean = mean + (G @ B).ravel() * u[k - 1]
        posterior = kalman.update(mean, P, y[k], H, R)
        mean, P = posterior.mean, posterior.covariance
        means.append(mean)
        stds.append(np.sqrt(np.diag(P)))
    return np.array(means), np.array(stds)


@pytest.fixture(params=["compiled", pytest.param("interpreted", marks=pytest.mark.slow)])
def engine(request: pytest.FixtureRequest) -> None:
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_model(spring(), duration_s=4.0, seed=0, inputs={"force_n": force})


@pytest.mark.usefixtures("engine")
@pytest.mark.parametrize("name", LEAST_SQUARES)
@pytest.mark.parametrize("interpolated", [(), ("force_n",)])
def test_every_estimator_is_the_kalman_filter_with_the_known_force(
    recording: Recording, name: str, interpolated: tuple[str, ...]
) -> None:
    model, u = spring(interpolated=interpolated), recording.inputs["force_n"]
    acting = (u[:-1] + u[1:]) / 2 if interpolated else u[:-1]
    history = run(create_estimator(name, model, **settings_read(name, SHORT)), recording)
    means, stds = filtered(model, recording.readings["ruler"], acting)
    assert np.abs((history.mean - means) / stds).max() < 1e-9
    assert np.abs(history.std / stds - 1).max() < 1e-9
    assert set(history.status) == {Status.SOLVED}


def test_without_the_force_the_position_is_lost() -> None:
    """Ten times the error: the classic's figure, over its own 50 s."""
    long = simulate_model(spring(), duration_s=50.0, seed=0, inputs={"force_n": np.cos})
    unknown = Recording("none", long.time_s, long.readings, inputs={"force_n": 0 * long.time_s})
    assert long.truth is not None
    rms = []
    for given in (long, unknown):
        history = run(create_estimator("ekf", spring()), given)
        away = history.mean - long.truth.states(("position_m", "velocity_m_s"), long.time_s)
        rms.append(np.sqrt(np.mean(away[:, 0] ** 2)))
    assert rms[1] > 5 * rms[0]


@pytest.fixture(scope="module")
def swing() -> Recording:
    return swung()


@needs_compiler
@pytest.mark.parametrize("name", ["ekf", "mhe-rti", "mhe"])
def test_compiled_is_interpreted_and_batch_is_steps(swing: Recording, name: str) -> None:
    """To the last bit, with inputs that are missing in a live stream."""
    model, settings = lamp(), settings_read(name, {"horizon": 4})
    compiled, interpreted = compiled_and_interpreted(
        lambda: create_estimator(name, model, **settings)
    )
    time_s, rows = swing.stacked(model)
    live = rows.copy()
    live[:, -1] = swing.inputs["gain"]
    assert np.isnan(live[:, -1]).any()
    stream = [Measurement(float(t), y) for t, y in zip(time_s, live, strict=True)]
    ours, theirs = (steps(estimator, stream) for estimator in (compiled, interpreted))
    for one, other in zip(ours, theirs, strict=True):
        same = np.testing.assert_array_equal if name != "mhe" else np.testing.assert_allclose
        same(one.state.mean, other.state.mean)
        same(one.state.covariance, other.state.covariance)
        assert one.status == other.status == Status.SOLVED
    if name == "mhe-rti":
        assert any(estimate.reused_stages for estimate in ours)
    history = run(compiled, swing)
    np.testing.assert_array_equal(history.mean, [e.state.mean for e in ours])
    _, batch = compiled.batch(compiled.init(), time_s, live)
    np.testing.assert_array_equal(batch.mean, history.mean)


@pytest.mark.parametrize("solver", [Mhe, MheIpopt, SequentialQp])
def test_windows_are_the_dense_optimum(swing: Recording, solver: Any) -> None:
    """Of SciPy, which rolls f out by itself; inputs and a gain that varies as told."""
    model, n = lamp(), 8
    rows = all_with_inputs(model, list(swing.measurements(model))[:n])
    L, x_bar = np.linalg.cholesky(model.prior.covariance), model.prior.mean
    std = model.noise_std

    def states(z: Array) -> Array:
        x = [x_bar + L @ z[:2]]
        for k in range(n - 1):
            dt = rows[k + 1].time_s - rows[k].time_s
            torque = (rows[k].y[2] + rows[k + 1].y[2]) / 2
            pull = torque - 9.0 * np.sin(x[k][0]) - 0.3 * x[k][1]
            rate = x[k][1] + dt * pull + 0.5 * np.sqrt(dt) * z[2 + k]
            x.append(np.array([x[k][0] + dt * x[k][1], rate]))
        return np.array(x)

    def residual(z: Array) -> Array:
        parts = [z]
        for x, row in zip(states(z), rows, strict=True):
            off = np.array([row.y[0] - row.y[3] * np.sin(x[0]), row.y[1] - x[1]]) / std
            parts.append(off[np.isfinite(off)])
        return np.concatenate(parts)

    best = least_squares(residual, np.zeros(n + 1), xtol=1e-15, ftol=1e-15, gtol=1e-14)
    guess = Trajectory(np.tile(x_bar, (n, 1)), np.zeros((n - 1, 1)))
    config = solver(model).config if solver is MheIpopt else MheConfig(horizon=10)
    found = solver(model, config).solve(model.prior, rows, guess)
    np.testing.assert_allclose(found.trajectory.states, states(best.x), rtol=0, atol=2e-6)
    assert found.cost == pytest.approx(best.cost, rel=1e-8)


@pytest.mark.cover
@needs_compiler
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_export_says_what_the_estimator_says(swing: Recording, name: str, real: str) -> None:
    model, settings = lamp(), settings_read(name, {"horizon": 4})
    export = export_texts(exportable(name, model, **settings), real)
    for words in ("PEN_INPUT_TORQUE = 2, /* N m */", "PEN_INPUT_GAIN = 3", "PEN_N_Y 4"):
        assert words in export.header
    theirs = run_measurements(Exported(export), swing.measurements(model))
    ours = run(create_estimator(name, model, **settings), swing)
    off = np.abs(theirs.mean - ours.mean) / ours.std
    assert off.max() < (1e-9 if real == "double" else 2e-2)
    exported = Exported(export)
    nothing = Measurement(0.0, model.stack({}, {"torque": 1.0}))
    with pytest.raises(InputError):
        exported.step(exported.init(), nothing)


@pytest.mark.parametrize("name", LEAST_SQUARES)
def test_an_input_that_was_never_known_is_refused(name: str) -> None:
    model = lamp()
    estimator = create_estimator(name, model, **settings_read(name, SHORT))
    row = model.stack({"shadow": np.array([0.2])}, {"torque": 1.0})
    with pytest.raises(InputError, match="input gain is nan and was not known before"):
        estimator.step(estimator.init(), Measurement(0.0, row))


def test_a_recording_without_the_input_is_refused(swing: Recording) -> None:
    model = lamp()
    bare = Recording("bare", swing.time_s, swing.readings)
    with pytest.raises(InputError, match="has no input torque"):
        bare.stacked(model)
    late = np.full(len(swing.time_s), np.nan)
    late[1:] = 1.0
    given = Recording("late", swing.time_s, swing.readings, inputs={"torque": late, "gain": late})
    with pytest.raises(InputError, match="has no value at the first instant"):
        given.stacked(model)
    parts = swing.select(["turns"])
    assert set(parts.inputs) == {"torque", "gain"}
    assert len(parts.time_s) == len(swing.time_s)


def test_a_table_holds_the_inputs(swing: Recording, tmp_path: Path) -> None:
    """Written and read back: the same rows, and the same truth."""
    model, path = lamp(), tmp_path / "swing.csv"
    write_table(recording_to_model_table(swing, model), path)
    again = read_recording(path, model)
    for one, other in zip(again.stacked(model), swing.stacked(model), strict=True):
        np.testing.assert_array_equal(one, other)
    assert swing.truth is not None
    assert again.truth is not None
    np.testing.assert_array_equal(again.truth.values, swing.truth.values)
    table = recording_to_model_table(swing, model)
    with pytest.raises(InputError, match="column gain is missing"):
        recording_from_model_table(table.drop(columns="gain"), model, "swing")
    with pytest.raises(InputError, match="column draught is unknown"):
        recording_from_model_table(table.assign(draught=0.0), model, "swing")
    late = dataclasses.replace(swing, arrivals={"turns": swing.time_s + 0.5})
    again = recording_from_model_table(recording_to_model_table(late, model), model, "late")
    given = ~np.isnan(late.arrivals["turns"])
    np.testing.assert_allclose(
        again.arrivals["turns"][given], late.arrivals["turns"][given], rtol=0, atol=1e-9
    )


def test_the_page_runs() -> None:
    names = run_python(PAGE)
    assert set(names["history"].status) == {Status.SOLVED}
    assert names["estimate"].status is Status.SOLVED
