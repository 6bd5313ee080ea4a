"""[Pen]'s stated aim: what is known at the start, and how errors and claims grow from it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmark.tasks.suite import Scope
from benchmark.tasks.task import Outcome, Task
from estimation.estimator import run
from recordings.simulate_pen import simulate
from suites.pen import known_start
from suites.pen.known_start import (
    AT_S,
    BEGIN,
    FREE,
    KNOWN,
    KNOWN_STARTS,
    NO_SPIN,
    SENSORS,
    KnownStart,
    told_start,
)
from suites.pen.suite import NAME, SUITE


def outcome(case: str, estimator: str, seed: int = 0) -> Outcome:
    return SUITE.run(Task(NAME, case, SENSORS, estimator, seed), Scope())


@pytest.mark.parametrize("case", [NO_SPIN, FREE])
def test_the_start_is_as_wrong_as_it_is_told(case: str) -> None:
    pen = known_start.KNOWN_STARTS[case].pen
    model = known_start._estimator(pen, "ekf").model
    truth = simulate(known_start._known(pen), ["accel", "gyro"], duration_s=0.05).truth
    assert truth is not None
    true = truth.states(model.state_names, truth.time_s[:1])[0]
    assert np.isfinite(true).all()
    told = [told_start(model, truth, seed) for seed in range(200)]
    std = np.sqrt(np.diag(told[0].covariance))
    errors = np.array([model.difference(t.mean, true).full().ravel() for t in told])
    spread = np.sqrt((errors**2).mean(axis=0)) / std
    assert ((spread > 0.8) & (spread < 1.2)).all()
    known = dict(zip(model.state_names, std, strict=True))
    assert known["tip_x_m"] == KNOWN["tip_std_m"]
    assert known["tip_z_velocity_m_s"] == KNOWN["velocity_std_m_s"]
    biases = [value for name, value in known.items() if name.startswith("accel") and "bias" in name]
    assert min(biases) > 0.1  # nobody knows them
    np.testing.assert_array_equal(told[3].mean, told_start(model, truth, 3).mean)


def test_nothing_says_where_the_pen_is(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[Any] = []

    def spied(estimator: Any, recording: Any, **options: Any) -> Any:
        given.append((estimator, recording))
        return run(estimator, recording, **options)

    monkeypatch.setattr(known_start, "run", spied)
    outcome(BEGIN, "mhe")
    ((estimator, recording),) = given
    assert recording.truth is None
    assert set(recording.readings) == {"accel", "gyro"}
    assert [sensor.name for sensor in estimator.model.sensors] == ["accel", "gyro", "rest"]


@pytest.mark.parametrize("case", KNOWN_STARTS)
def test_errors_and_claims_are_told_at_each_time(case: str) -> None:
    row = KNOWN_STARTS[case]
    found = {q.name: q for q in outcome(case, row.estimators[-1]).quantities}
    at = [t for t in AT_S if t <= row.duration_s]
    assert [name for name in found if name.startswith("tip")] == [f"tip at {t:g} s" for t in at]
    claims = [found[f"tip at {t:g} s"].claimed or 0.0 for t in at]
    assert (np.diff(claims) > 0).all()
    assert claims[0] < 1.0  # mm
    for quantity in found.values():
        assert quantity.claimed is not None
        assert 0 < quantity.rmse < 4 * quantity.claimed


def test_ipopt_ends_where_mhe_ends_from_a_known_start(monkeypatch: pytest.MonkeyPatch) -> None:
    short = KnownStart(KNOWN_STARTS[BEGIN].pen, ("mhe-ipopt",), 0.05)
    monkeypatch.setattr(known_start, "KNOWN_STARTS", {BEGIN: short})
    found = {q.name: q for q in outcome(BEGIN, "mhe-ipopt").quantities}
    assert found["distance from mhe"].max_error < 1e-6
