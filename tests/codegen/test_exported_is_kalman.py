"""On a linear model every export is the textbook Kalman filter, in either form."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.status import Status
from tests.codegen.exports import FORMS, exported, told
from tests.engines import needs_compiler
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times

pytestmark = needs_compiler

SYSTEMS = {"one axis": constant_acceleration_system(1), "coupled": coupled_system(3)}
TOLERANCE_STD = {"double": 1e-12, "float": 1e-4}
"""Of one step; below, that of a run."""


@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
@pytest.mark.parametrize("system_name", SYSTEMS)
@pytest.mark.parametrize(("real", "form"), FORMS)
def test_mean_and_covariance_are_the_textbooks(
    name: str, system_name: str, real: str, form: str
) -> None:
    system, rng = SYSTEMS[system_name], np.random.default_rng(11)
    measurements = system.simulate(irregular_times(150, rng), rng, missing=0.4)
    estimates = told(exported(name, system.model, real, form), measurements)
    tolerance = 30 * TOLERANCE_STD[real]
    for estimate, wanted in zip(estimates, system.textbook(measurements), strict=True):
        std = np.sqrt(np.diag(wanted.covariance))
        error_P = (estimate.state.covariance - wanted.covariance) / np.outer(std, std)
        assert np.abs((estimate.state.mean - wanted.mean) / std).max() < tolerance
        assert np.abs(error_P).max() < tolerance
        rows = wanted.rows
        assert estimate.status is (Status.SOLVED if len(rows) else Status.NO_READING)
        S = estimate.innovation_covariance[np.ix_(rows, rows)]
        std_v = np.sqrt(np.diag(wanted.innovation_covariance))
        error_v = (estimate.innovation[rows] - wanted.innovation) / std_v
        error_S = (S - wanted.innovation_covariance) / np.outer(std_v, std_v)
        assert np.abs(error_v).max(initial=0) < tolerance
        assert np.abs(error_S).max(initial=0) < tolerance
