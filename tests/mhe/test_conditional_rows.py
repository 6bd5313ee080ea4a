"""A row of the inequality is demanded only where the instant has the readings it needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheIpoptConfig
from mhe.reference.ipopt import MheIpopt
from models.paper import Paper
from models.pen import pen_model
from models.state_space import StateSpaceModel
from suites.optimum.cases import rolled_out
from tests.configs import config_for
from tests.linear_models import LinearSystem, constant_acceleration_system, coupled_system
from tests.mhe.runs import ESTIMATORS, linear_batch, reference_window, run_mhe
from tests.models.pens import ACCELEROMETER, CAMERA, pen
from tests.references.least_distance import solve_held

TOLERANCE = 1e-6
N_STAGES = 9

SYSTEMS = {
    "one axis": (constant_acceleration_system(1), 4),
    "two axes": (constant_acceleration_system(2), 1),
    "coupled": (coupled_system(3), 2),
}


def conditional(
    system: LinearSystem, measurements: list[Measurement]
) -> tuple[StateSpaceModel, float]:
    """Half of the free solution's stages exceed s0 + s1 <= c, demanded with the first reading."""
    states = linear_batch(system, measurements).solve().states
    total = float(np.median(states[:, 0] + states[:, 1]))
    needs = [system.model.reading_names[0]]
    return system.model.constrained(lambda x: x[0] + x[1] - total, needs), total


@pytest.mark.cover
@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("name", SYSTEMS)
def test_windows_while_they_grow(name: str, estimator: str) -> None:
    system, seed = SYSTEMS[name]
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 0.2, N_STAGES))
    measurements = system.simulate(times, rng, missing=0.4)
    model, total = conditional(system, measurements)
    C, d = np.ones((1, 2)) @ np.eye(2, model.n_x), np.array([total])
    asked = np.array([np.isfinite(m.y[:1]) for m in measurements])
    assert 0 < asked.sum() < N_STAGES
    held = beyond = 0
    config = config_for(estimator, horizon=N_STAGES - 1)
    for k, estimate in enumerate(run_mhe(model, measurements, config, estimator)):
        batch, demanded = linear_batch(system, measurements[: k + 1]), asked[: k + 1]
        wanted = solve_held(batch, C, d, demanded)
        assert estimate.window is not None
        assert estimate.status.is_solved
        error = np.abs((estimate.window.states - wanted.states) / wanted.std).max()
        assert error < TOLERANCE, f"window of {k + 1} stages"
        excess = estimate.window.states @ C.T - d
        assert (excess[demanded] < 1e-8).all()
        held += int((wanted.multipliers > 1e-3).sum())
        beyond += int((excess[~demanded] > 1e-3).sum())
    assert held > 0, "the row never held"
    assert beyond > 0, "the row was never exceeded where nothing demands it"


@pytest.mark.parametrize("seed", [1, 4, 7])
def test_an_unfinished_window_may_exceed_what_nothing_demands(seed: int) -> None:
    """From the free optimum, which exceeds the row only where it is not demanded.

    IPOPT is stopped after two iterations, off that optimum, so the start is the better of the
    two; but not where every instant demands the row, which the start then breaks.
    """
    system = constant_acceleration_system(1)
    prior, rng = system.model.prior, np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 0.2, N_STAGES))
    measurements = tuple(system.simulate(times, rng, missing=0.4))
    config = MheIpoptConfig(horizon=N_STAGES - 1)
    start = rolled_out(system.model, prior.mean, measurements)
    optimum = MheIpopt(system.model, config).solve(prior, measurements, start).trajectory
    asked = np.array([np.isfinite(m.y[0]) for m in measurements])
    position = optimum.states[:, 0]
    limit = float(position[asked].max()) + 0.05
    assert position[~asked].max() > limit + 0.1, "another seed is needed"

    def moved(needs: list[str]) -> float:
        model = system.model.constrained(lambda x: x[0] - limit, needs)
        mhe = MheIpopt(model, replace(config, max_iterations=2))
        found = mhe.solve(prior, measurements, optimum)
        assert found.status is Status.ITERATION_LIMIT
        return float(np.abs(found.trajectory.states[:, 0] - position).max())

    assert moved([system.model.reading_names[0]]) < 1e-9
    assert moved([]) > 0.1


def test_a_pen_is_on_its_paper_while_it_touches() -> None:
    """Held to a tenth of a millimetre while the contact reads; free above it when it does not."""
    sensors = {
        "accel": {"kind": "accelerometer", **ACCELEROMETER},
        "camera": {"kind": "pose_camera", **CAMERA, "position_std_m": 1e-3},
        "tip": {"kind": "contact", "std_m": 1e-2},
    }
    config = pen(6, sensors)
    free = pen_model(config)
    config = config.model_copy(update={"paper": Paper(touch_tolerance_m=1e-4)})
    held, rng = pen_model(config), np.random.default_rng(0)
    height = np.array([-2, -1, 1, 3, 5, 4, 2, 1, 0, -2]) * 1e-3
    touches = np.array([1, 1, 1, 0, 0, 0, 1, 1, 1, 1], dtype=bool)
    measurements = []
    for k, z in enumerate(height):
        pose = np.array([0, 0, z, *np.asarray(held.sensor("camera").h(held.prior.mean))[3:, 0]])
        pose[:3] += 1e-4 * rng.standard_normal(3)
        force = np.asarray(held.sensor("accel").h(held.prior.mean)).ravel()
        readings = {"camera": pose, "accel": force}
        if touches[k]:
            readings["tip"] = np.zeros(1)
        measurements.append(Measurement(0.05 * k, held.stack(readings)))
    loose, tight = (reference_window(model, measurements) for model in (free, held))
    assert tight.status.is_solved
    z, unheld = (np.array(found.trajectory.states)[:, 2] for found in (tight, loose))
    assert (z > -1e-9).all()
    assert (z[touches] < 1e-4 + 1e-9).all()
    assert z[~touches].max() > 1e-3
    assert unheld.min() < -5e-4
    assert unheld[touches].max() > 5e-4
