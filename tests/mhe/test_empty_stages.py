"""Empty stages inserted into a full-length window change nothing."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from models.state_space import StateSpaceModel
from tests.configs import config_for
from tests.estimation.pens import draw_pen_run
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times
from tests.mhe.runs import ESTIMATORS, full_length, run_mhe, with_empty_stages

TOLERANCE_STD = 1e-10


def case(name: str) -> tuple[StateSpaceModel, list[Measurement]]:
    rng = np.random.default_rng(51)
    if name == "pen":
        run = draw_pen_run(8, 3)
        return run.model, run.measurements
    system = coupled_system(2) if name == "coupled" else constant_acceleration_system(2)
    return system.model, system.simulate(irregular_times(12, rng), rng)


# On the pen an empty stage is one more pass for `mhe-rti`: it comes nearer to the optimum.
CASES = [
    *itertools.product(["coupled", "constant acceleration"], ESTIMATORS),
    *(("pen", estimator) for estimator in ESTIMATORS if estimator != "mhe-rti"),
]


@pytest.mark.parametrize(("name", "estimator"), CASES)
def test_inserted_stages_change_nothing_at_the_others(name: str, estimator: str) -> None:
    model, measurements = case(name)
    filled = with_empty_stages(measurements)
    assert len(filled) > len(measurements) + 3
    plain, split = (
        run_mhe(
            model,
            ms,
            config_for(estimator, horizon=full_length(ms), reuse_threshold=0.0),
            estimator,
        )
        for ms in (measurements, filled)
    )
    row_of = {measurement.time_s: row for row, measurement in enumerate(filled)}
    rows = [row_of[measurement.time_s] for measurement in measurements]
    for k, row in enumerate(rows):
        one, other = plain[k], split[row]
        std = one.state.std
        error_P = (other.state.covariance - one.state.covariance) / np.outer(std, std)
        assert np.abs((other.state.mean - one.state.mean) / std).max() < TOLERANCE_STD
        assert np.abs(error_P).max() < TOLERANCE_STD
        assert one.window is not None
        assert other.window is not None
        common = other.window.states[rows[: k + 1]]
        assert np.abs((common - one.window.states) / std).max() < TOLERANCE_STD
    for row in set(range(len(filled))) - set(rows):
        assert split[row].status is Status.NO_READING


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_two_readings_at_one_time_are_one_reading_of_both(estimator: str) -> None:
    system, rng = coupled_system(2), np.random.default_rng(52)
    together = system.simulate(irregular_times(8, rng), rng, missing=0.0)
    apart = []
    for measurement in together:
        first, second = measurement.y.copy(), measurement.y.copy()
        first[1:], second[:1] = np.nan, np.nan
        apart += [Measurement(measurement.time_s, y) for y in (first, second)]
    one = run_mhe(
        system.model, together, config_for(estimator, horizon=full_length(together)), estimator
    )
    two = run_mhe(
        system.model, apart, config_for(estimator, horizon=full_length(apart)), estimator
    )[1::2]
    for a, b in zip(one, two, strict=True):
        assert np.abs((a.state.mean - b.state.mean) / a.state.std).max() < TOLERANCE_STD
