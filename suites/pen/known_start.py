"""[Pen]'s stated aim: tip and attitude from accelerometer and gyroscope, from a known start.

Nothing else says where the pen is (no writing area), so errors only grow: how fast, and what an
estimator claims of it. The start is told with an error that is drawn from its covariance: pose and
rates as well as a hand can lay a pen down, accelerations and biases as the pen's file has them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.configurations import CONFIGURATIONS
from benchmark.from_mhe import NEAR, distance_quantity
from benchmark.from_mhe import REFERENCE as OPTIMUM
from benchmark.tasks.history import outcome
from benchmark.tasks.task import Outcome, Task
from estimation.estimator import Estimator, run
from estimation.recording import Truth
from models.gaussian import GaussianState
from models.pen import pen_model
from models.pen_config import PenConfig
from models.priors import replaced_prior
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.simulate_pen import simulate
from suites.pen.pen_cases import DURATION_S, MOTION
from suites.pen.told_pens import FREE_PEN, NO_SPIN_PEN, ToldPen, told_pen
from suites.pen_quantities import quantities_at

SENSORS = "accel+gyro"
AT_S = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, DURATION_S)
"""When errors are told, s after the start."""

KNOWN: Mapping[str, float] = MappingProxyType(
    {
        "tip_std_m": 1e-4,
        "azimuth_std_rad": math.radians(0.1),
        "elevation_std_rad": math.radians(0.1),
        "spin_std_rad": math.radians(0.1),
        "velocity_std_m_s": 1e-3,
        "angle_rate_std_rad_s": 0.01,
    }
)
"""Field of the prior → how well it is known at the start."""


@dataclass(frozen=True)
class KnownStart:
    """A case.

    Parameters
    ----------
    pen : which moves as it is told to
    estimators : that run on it
    duration_s : of the recording
    """

    pen: ToldPen
    estimators: tuple[str, ...] = ("mhe-rti", "ekf")
    duration_s: float = DURATION_S


NO_SPIN, FREE = "known start, no-spin pen", "known start, free pen"
BEGIN_S = 0.2
"""What IPOPT solves on every seed: by then the tip is lost."""
BEGIN = f"{NO_SPIN}, {BEGIN_S:g} s"
KNOWN_STARTS: Mapping[str, KnownStart] = MappingProxyType(
    {
        BEGIN: KnownStart(NO_SPIN_PEN, (OPTIMUM, NEAR), BEGIN_S),
        NO_SPIN: KnownStart(NO_SPIN_PEN),
        FREE: KnownStart(FREE_PEN),
    }
)
"""Name → case."""


def run_known_start(task: Task) -> Outcome:
    """Run an estimator from a known start and tell its errors at `AT_S`."""
    row = KNOWN_STARTS[task.case]
    estimator = _estimator(row.pen, task.estimator)
    recording = simulate(
        _known(row.pen),
        CONFIGURATIONS[SENSORS].sensors,
        motion=MOTION,
        duration_s=row.duration_s,
        seed=task.seed,
    )
    truth = recording.truth
    assert truth is not None
    model = estimator.model
    told, blind = told_start(model, truth, task.seed), replace(recording, truth=None)
    is_reference = task.estimator == OPTIMUM
    history = run(estimator, blind, prior=told, covariances=is_reference)
    quantities = quantities_at(model, history, truth, [at for at in AT_S if at <= row.duration_s])
    if is_reference:
        near = run(_estimator(row.pen, NEAR), blind, prior=told)
        quantities.append(distance_quantity(model, history, near))
    return outcome(model.name, history, quantities)


def told_start(model: StateSpaceModel, truth: Truth, seed: int) -> GaussianState:
    """Return the prior whose mean is off the truth by an error drawn from its covariance.

    Without a camera a chain that bounds the velocity starts from its stationary one: known it is
    independent of the rest.
    """
    true = truth.states(model.state_names, truth.time_s[:1])[0]
    moving = [name for name in model.state_names if name.endswith("_velocity_m_s")]
    told = replaced_prior(model, dict.fromkeys(moving, 0.0), KNOWN["velocity_std_m_s"])
    drawn = stream(seed_sequence(seed), "error of the known start").standard_normal(model.n_x)
    away = np.linalg.cholesky(told.covariance) @ drawn
    mean = np.asarray(model.retract(true, away)).ravel()
    return GaussianState(mean, told.covariance)


@cache
def _known(told: ToldPen) -> PenConfig:
    """Return a pen whose start is known."""
    pen = told_pen(told)
    return pen.model_copy(update={"prior": pen.prior.model_copy(update=dict(KNOWN))})


@cache
def _estimator(told: ToldPen, name: str) -> Estimator[Any]:
    return create_estimator(name, _model(told))


@cache
def _model(told: ToldPen) -> StateSpaceModel:
    """Return the model that the estimators of a pen share, with what is derived of it."""
    return pen_model(_known(told), CONFIGURATIONS[SENSORS].sensors, writing_area=False)
