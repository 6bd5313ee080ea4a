"""Running an MHE over measurements, and the same window as a batch problem."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from estimation.estimate import Estimate
from estimation.estimator import Estimator
from estimation.recording import Measurement
from mhe.config import MheIpoptConfig, WindowConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from mhe.trajectory import WindowSolution
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.optimum.cases import rolled_out
from tests.linear_models import LinearSystem
from tests.references.batch import BatchProblem, linear_readings

ESTIMATORS: Mapping[str, Callable[[StateSpaceModel, Any], Estimator[Any]]] = {
    kind.name: kind for kind in (MheIpopt, MheRti, Mhe)
}
REAL_TIME, CONVERGING = ("mhe-rti", "mhe"), ("mhe-ipopt", "mhe")
ON_A_PEN = (pytest.param("mhe-ipopt", marks=pytest.mark.slow), "mhe")
"""`CONVERGING`, on windows of a pen; quick tests have `tests.mhe.test_optimum`: both end alike."""


def run_mhe(
    model: StateSpaceModel,
    measurements: list[Measurement],
    config: WindowConfig,
    estimator: str = "mhe-ipopt",
) -> list[Estimate]:
    """Return the estimates of all steps."""
    mhe = ESTIMATORS[estimator](model, config)
    state, estimates = mhe.init(), []
    for measurement in measurements:
        state, estimate = mhe.step(state, measurement)
        estimates.append(estimate)
    return estimates


def reference_window(model: StateSpaceModel, measurements: list[Measurement]) -> WindowSolution:
    """Return IPOPT's solution of a window over all measurements, from the prior without noise.

    A solver is built for this length alone, and for none of the windows that would grow to it.
    """
    reference = MheIpopt(model, MheIpoptConfig(horizon=full_length(measurements)))
    guess = rolled_out(model, model.prior.mean, measurements)
    return reference.solve(model.prior, tuple(measurements), guess)


def full_length(measurements: list[Measurement]) -> int:
    """Return the horizon of a window over all measurements."""
    return len(measurements) - 1


def linear_batch(
    system: LinearSystem,
    measurements: list[Measurement],
    mean: Array | None = None,
    covariance: Array | None = None,
) -> BatchProblem:
    """Return the batch problem of a window; the model's prior unless another is given."""
    prior = system.model.prior
    steps = system.steps(np.array([m.time_s for m in measurements]))
    y = np.array([m.y for m in measurements])
    return BatchProblem(
        prior.mean if mean is None else mean,
        np.linalg.cholesky(prior.covariance if covariance is None else covariance),
        [F for F, _ in steps],
        [G for _, G in steps],
        linear_readings(y, system.H, np.sqrt(np.diag(system.R))),
    )


def with_empty_stages(measurements: list[Measurement]) -> list[Measurement]:
    """Insert a stage without readings into two of three gaps."""
    filled = measurements[:1]
    for k, measurement in enumerate(measurements[1:]):
        if k % 3:
            between = filled[-1].time_s + 0.37 * (measurement.time_s - filled[-1].time_s)
            filled.append(Measurement(between, np.full_like(measurement.y, np.nan)))
        filled.append(measurement)
    return filled
