"""Times: handed over in double precision, and resolved as well however long an export runs."""

from __future__ import annotations

import numpy as np
import pytest

from codegen.exported import Exported
from estimation.recording import Measurement
from estimation.status import Status
from models.errors import InputError
from tests.closeness import estimate_error, mean_error
from tests.codegen.exports import Settings, exported, told
from tests.engines import needs_compiler
from tests.linear_models import coupled_system

pytestmark = needs_compiler

SYSTEM = coupled_system(3)
SETTINGS: dict[str, Settings] = {"ekf": {}, "mhe-rti": {"horizon": 7}}


def run(estimator: Exported, measurements: list[Measurement], later: float) -> list[np.ndarray]:
    """Return all numbers that steps tell, at times that are shifted."""
    shifted = [Measurement(m.time_s + later, m.y) for m in measurements]
    return [
        np.concatenate([e.state.mean, e.state.covariance.ravel(), e.innovation, [e.kkt_residual]])
        for e in told(estimator, shifted)
    ]


@pytest.mark.cover
@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("later", [2.0**13, 2.0**30])
def test_single_precision_does_not_feel_when_it_is(name: str, later: float) -> None:
    """Times on a grid that both resolve: every bit stays, hours and decades later."""
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.integers(1, 12, 300)) / 128
    measurements = SYSTEM.simulate(times, rng, 0.3)
    estimator = exported(name, SYSTEM.model, "float", settings=SETTINGS[name])
    np.testing.assert_array_equal(
        run(estimator, measurements, 0.0), run(estimator, measurements, later)
    )


@pytest.mark.parametrize("name", SETTINGS)
def test_intervals_stay_right_at_any_time(name: str) -> None:
    """10 ms apart in the tenth hour: a float of the time itself would take steps of 4 ms."""
    rng = np.random.default_rng(2)
    times = 36_000 + np.cumsum(rng.uniform(0.008, 0.012, 400))
    measurements = SYSTEM.simulate(times, rng, 0.2)
    single = told(exported(name, SYSTEM.model, "float", settings=SETTINGS[name]), measurements)
    double = told(exported(name, SYSTEM.model, "double", settings=SETTINGS[name]), measurements)
    errors = [estimate_error(SYSTEM.model, a, b) for a, b in zip(single, double, strict=True)]
    assert max(errors) < 1e-4
    assert max(errors[200:]) < 3 * max(errors[:200]), "errors do not pile up"
    assert [e.time_s for e in single] == times.tolist()


@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("gap_s", [1.0, 60.0])
def test_a_gap_within_the_window(name: str, gap_s: float) -> None:
    rng = np.random.default_rng(3)
    times = np.cumsum(np.full(60, 0.01))
    times[30:] += gap_s
    measurements = SYSTEM.simulate(times, rng, 0.2)
    single = told(exported(name, SYSTEM.model, "float", settings=SETTINGS[name]), measurements)
    double = told(exported(name, SYSTEM.model, "double", settings=SETTINGS[name]), measurements)
    for a, b in zip(single, double, strict=True):
        assert estimate_error(SYSTEM.model, a, b) < 1e-3
        assert a.status is b.status


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", SETTINGS)
def test_a_moment_too_late_leaves_the_newest_instant(name: str, real: str) -> None:
    """Even by less than single precision resolves; at the very time it is not late."""
    estimator = exported(name, SYSTEM.model, real, settings=SETTINGS[name])
    y = np.array([0.1, 0.2, 0.3])
    state, _ = estimator.step(estimator.init(), Measurement(1000.0, y))
    state, _ = estimator.step(state, Measurement(1000.01, y))
    _, late = estimator.step(state, Measurement(float(np.nextafter(1000.01, 0)), y))
    assert late.time_s == 1000.01
    _, again = estimator.step(state, Measurement(1000.01, y))
    assert again.status is Status.SOLVED
    if name == "mhe-rti":
        assert late.status is Status.SOLVED
        tolerance = 1e-9 if real == "double" else 1e-4
        assert mean_error(SYSTEM.model, late.state.mean, again.state) < tolerance


@pytest.mark.parametrize("real", ["double", "float"])
def test_older_than_the_window_is_late(real: str) -> None:
    estimator = exported("mhe-rti", SYSTEM.model, real, settings=SETTINGS["mhe-rti"])
    y, state = np.array([0.1, 0.2, 0.3]), estimator.init()
    for k in range(20):
        state, before = estimator.step(state, Measurement(1000 + 0.01 * k, y))
    after, late = estimator.step(state, Measurement(1000.05, y))
    assert late.status is Status.LATE
    assert late.time_s == before.time_s
    np.testing.assert_array_equal(late.state.mean, before.state.mean)
    _, one = estimator.step(state, Measurement(1000.2, y))
    _, other = estimator.step(after, Measurement(1000.2, y))
    np.testing.assert_array_equal(one.state.mean, other.state.mean)


@pytest.mark.parametrize("time_s", [np.nan, np.inf, -np.inf])
def test_a_time_that_is_no_number_changes_nothing(time_s: float) -> None:
    estimator = exported("ekf", SYSTEM.model)
    state, _ = estimator.step(estimator.init(), Measurement(0.0, np.zeros(3)))
    with pytest.raises(InputError, match="expected a number"):
        estimator.step(state, Measurement(time_s, np.zeros(3)))
    assert bytes(estimator.state.raw) == state.data
