"""Runs of one estimator from many starts, which is built only once."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from benchmark.from_mhe import REFERENCE
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.recording import Recording
from models.gaussian import GaussianState
from pen_mhe.estimators import create_estimator, settings_read
from suites.gyro_free.pen import TwoAccelerometers, two_accelerometers

SETTINGS: Mapping[str, Any] = MappingProxyType({"tolerance": 1e-5, "max_iterations": 30})
"""Of what iterates by passes: 1e-5 of a standard deviation is nothing, and 30 iterations bound the
time of a task."""
REFERENCE_SETTINGS: Mapping[str, Any] = MappingProxyType({"tolerance": SETTINGS["tolerance"]})
"""Of IPOPT, which 30 iterations would stop far from its optimum."""


def run_from(
    name: str,
    pen: TwoAccelerometers,
    prior: GaussianState,
    recording: Recording,
    covariances: bool = False,
) -> EstimateHistory:
    """Run an estimator of the benchmark on a pen's recording.

    Parameters
    ----------
    name : of the estimator
    pen : the pen that it is told of
    prior : of the first state
    covariances : whether they are kept in full
    """
    return run(_estimator(name, pen), recording, prior=prior, covariances=covariances)


@cache
def _estimator(name: str, pen: TwoAccelerometers) -> Estimator[Any]:
    settings = REFERENCE_SETTINGS if name == REFERENCE else settings_read(name, SETTINGS)
    return create_estimator(name, two_accelerometers(pen)[1], **settings)
