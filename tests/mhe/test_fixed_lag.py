"""Estimates at a fixed lag: on linear models those of a textbook's smoother, elsewhere causal.

The newest estimates stay as they are without any lag, to the last bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest

import pen_mhe as pm
from estimation.estimate import EstimateHistory
from estimation.estimator import BatchEstimator, Estimator, run, run_measurements
from estimation.recording import Measurement
from estimation.status import Status
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from models.errors import InputError
from models.own_models import OwnSensor, own_model
from pen_mhe.estimators import create_estimator
from recordings.thinning import CameraThinning, thinned
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times
from tests.mhe import pendulum
from tests.references.smoother import smoothed

SYSTEMS = {"axes": constant_acceleration_system(2, density=20.0), "coupled": coupled_system(3)}
KINDS: dict[str, Any] = {"mhe-rti": MheRti, "mhe": Mhe}
ENGINES = ("compiled", "interpreted")
HORIZON, LAGS = 9, (1, 4, 9)
TOLERANCE_STD = 1e-9


def both_engines(name: str, model: Any, **settings: Any) -> dict[str, Estimator[Any]]:
    """An estimator by its engines; IPOPT has one."""
    if name == "mhe-ipopt":
        return {"compiled": create_estimator(name, model, **settings)}
    pair = compiled_and_interpreted(lambda: create_estimator(name, model, **settings))
    return dict(zip(ENGINES, pair, strict=True))


def batch(
    estimator: Estimator[Any], measurements: Sequence[Measurement], **options: Any
) -> EstimateHistory:
    assert isinstance(estimator, BatchEstimator)
    times = np.array([m.time_s for m in measurements])
    rows = np.array([m.y for m in measurements])
    return estimator.batch(estimator.init(), times, rows, **options)[1]


@needs_compiler
@pytest.mark.parametrize(
    "arrival_cost", [pytest.param("filtered", marks=pytest.mark.slow), "smoothed"]
)
@pytest.mark.parametrize("name", ["mhe-rti", "mhe", "mhe-ipopt"])
@pytest.mark.parametrize("which", SYSTEMS)
def test_on_linear_models_it_is_the_textbooks_smoother(
    which: str, name: str, arrival_cost: str
) -> None:
    system, rng = SYSTEMS[which], np.random.default_rng(7)
    measurements = system.simulate(irregular_times(34, rng), rng, missing=0.35)
    times = [m.time_s for m in measurements]
    filtered = system.textbook(measurements)
    settings = {"horizon": HORIZON, "arrival_cost": arrival_cost, "lag_samples": LAGS}
    for estimator in both_engines(name, system.model, **settings).values():
        history = run_measurements(estimator, measurements, covariances=True)
        for lag in LAGS:
            told = history.at_lag(lag)
            np.testing.assert_array_equal(told.time_s, times[: len(times) - lag])
            for k, (mean, P) in enumerate(zip(told.mean, told.covariance, strict=True)):
                x, wanted = smoothed(filtered, times, system.F, system.Q, k + lag, lag)
                std = np.sqrt(np.diag(wanted))
                assert np.abs((mean - x) / std).max() < TOLERANCE_STD
                assert np.abs((P - wanted) / np.outer(std, std)).max() < TOLERANCE_STD
                np.testing.assert_array_equal(P, P.T)
                assert np.abs(told.std[k] / std - 1).max() < TOLERANCE_STD


def draw(which: str) -> tuple[Any, list[Measurement]]:
    if which == "pendulum":
        return pendulum.model(), pendulum.simulate(26, 3)
    run = pens.draw_pen_run(26, seed=11)
    return run.model, list(run.measurements)


CASES = [
    *(("pendulum", name) for name in KINDS),
    ("pen", "mhe-rti"),
    pytest.param("pen", "mhe", marks=pytest.mark.slow),
]


@needs_compiler
@pytest.mark.parametrize(("which", "name"), CASES)
def test_batch_steps_and_both_engines_say_the_same(which: str, name: str) -> None:
    model, measurements = draw(which)
    engines = both_engines(name, model, horizon=6, lag_samples=(2, 6))
    histories = [run_measurements(each, measurements) for each in engines.values()]
    histories += [batch(each, measurements) for each in engines.values()]
    for lag in (2, 6):
        first, *others = (history.at_lag(lag) for history in histories)
        assert len(first) == len(measurements) - lag
        for other in others:
            assert np.abs((other.mean - first.mean) / first.std).max() < 1e-9
            assert np.abs(other.std / first.std - 1).max() < 1e-9
            assert np.abs(other.derived_std - first.derived_std).max(initial=0.0) < 1e-9
        assert np.median(first.std / histories[0].std[:-lag]) < 1


@needs_compiler
@pytest.mark.parametrize(
    ("which", "reuse"),
    [
        *(("pendulum", reuse) for reuse in (None, 0.0, 3.0)),
        ("pen", 0.5),
        *(pytest.param("pen", reuse, marks=pytest.mark.slow) for reuse in (None, 0.0, 3.0)),
    ],
)
def test_the_newest_estimates_are_those_without_a_lag(which: str, reuse: float | None) -> None:
    name = "mhe" if reuse is None else "mhe-rti"
    settings = {} if reuse is None else {"reuse_threshold": reuse}
    model, measurements = draw(which)
    plain = both_engines(name, model, horizon=6, **settings)
    lagged = both_engines(name, model, horizon=6, lag_samples=(2, 6), **settings)
    for engine in ENGINES:
        wanted, found = (batch(each[engine], measurements) for each in (plain, lagged))
        assert found.at_lag(0) is found
        for block in ("time_s", "mean", "std", "derived", "derived_std", "innovation"):
            np.testing.assert_array_equal(getattr(found, block), getattr(wanted, block))
        assert found.status == wanted.status


@needs_compiler
@pytest.mark.parametrize("name", ["mhe-rti", "mhe", "mhe-ipopt"])
def test_it_uses_nothing_that_comes_after_its_newest_sample(name: str) -> None:
    model, measurements = draw("pendulum")
    lag, cut, rng = 4, 15, np.random.default_rng(2)
    changed = [
        m if k < cut else Measurement(m.time_s, m.y + rng.normal(0, 0.1, m.y.shape))
        for k, m in enumerate(measurements[: cut + 3])
    ]
    for estimator in both_engines(name, model, horizon=6, lag_samples=lag).values():
        before, after = (
            run_measurements(estimator, each).at_lag(lag) for each in (measurements, changed)
        )
        same = cut - lag  # rows whose newest sample is before the change
        for block in ("time_s", "mean", "std"):
            ours, theirs = getattr(before, block), getattr(after, block)
            np.testing.assert_array_equal(ours[:same], theirs[:same])
        assert not np.array_equal(before.mean[same], after.mean[same])


@needs_compiler
def test_where_factors_are_kept_the_pass_goes_back_to_what_is_told() -> None:
    """On a linear model factors are exact for ever: so is then all that is told."""
    system, rng = SYSTEMS["coupled"], np.random.default_rng(3)
    measurements = system.simulate(irregular_times(60, rng), rng, missing=0.2)
    times, filtered = [m.time_s for m in measurements], system.textbook(measurements)
    for engine, estimator in both_engines(
        "mhe-rti", system.model, horizon=20, lag_samples=20, reuse_threshold=50.0
    ).items():
        history = run_measurements(estimator, measurements)
        if engine == "compiled":
            assert np.median(history.reused_stages) > 15
        told = history.at_lag(20)
        for k, mean in enumerate(told.mean):
            x, P = smoothed(filtered, times, system.F, system.Q, k + 20, 20)
            assert np.abs((mean - x) / np.sqrt(np.diag(P))).max() < TOLERANCE_STD


def two_minima() -> tuple[Any, list[Measurement]]:
    """A state that is read by s² + s³/5, and one whose readings nobody would believe.

    The first descent ends left of 0, the second one right of it, where the readings know more and
    the cost is higher.
    """
    model = own_model(
        "two minima",
        {"s": (-0.19, 2.0), "offset": (0.0, 0.1)},
        lambda x, w, dt: x + 0.01 * ca.sqrt(dt) * w,
        2,
        {
            "curved": OwnSensor(lambda x: x[0] ** 2 + x[0] ** 3 / 5, {"c": "m"}, 0.1),
            "plain": OwnSensor(lambda x: x[1], {"o": "m"}, 0.1),
        },
    )
    return model, [Measurement(0.1 * k, np.array([1.0, 3.0])) for k in range(5)]


@needs_compiler
def test_where_a_second_start_was_of_no_use_the_first_trajectory_is_told_of() -> None:
    model, measurements = two_minima()
    for estimator in both_engines("mhe", model, horizon=6, lag_samples=2).values():
        for k, estimate in enumerate(steps(estimator, measurements)[2:], start=3):
            assert Status.IMPROBABLE in estimate.status
            assert estimate.window is not None
            [told] = estimate.lagged
            x = estimate.window.states[-3]
            np.testing.assert_array_equal(told.state.mean, x)
            assert x[0] < 0
            slope = 2 * x[0] + 3 / 5 * x[0] ** 2
            known = 0.1 / (abs(slope) * np.sqrt(k))  # as if the state stood still
            assert abs(told.state.std[0] / known - 1) < 0.05


@needs_compiler
def test_a_late_step_has_no_row_and_one_without_time_no_deviation() -> None:
    model, measurements = draw("pendulum")
    late = Measurement(measurements[4].time_s, measurements[4].y)
    disturbed = [*measurements[:12], late, *measurements[12:]]
    for estimator in both_engines("mhe-rti", model, horizon=6, lag_samples=3).values():
        history = run_measurements(estimator, disturbed)
        assert history.status[12] is Status.LATE
        told = history.at_lag(3)
        np.testing.assert_array_equal(told.time_s, [m.time_s for m in measurements[:-3]])
        estimates = steps(estimator, disturbed)
        assert [len(e.lagged) for e in estimates[:5]] == [0, 0, 0, 1, 1]
        assert estimates[12].lagged == ()
        assert estimates[-1].lagged[0].time_s == measurements[-4].time_s


@needs_compiler
def test_a_step_without_time_for_a_pass_does_not_say_how_well_it_knows() -> None:
    model, measurements = draw("pendulum")
    ticks = itertools.count()
    config = MheConfig(horizon=6, lag_samples=3, deadline_s=0.5)
    pair = compiled_and_interpreted(lambda: Mhe(model, config, clock=lambda: float(next(ticks))))
    for estimator in pair:
        predicted = [e for e in steps(estimator, measurements) if Status.PREDICTED in e.status]
        told = [e.lagged[0] for e in predicted if e.lagged]
        assert told
        assert all(np.isfinite(each.state.mean).all() for each in told)
        assert all(np.isnan(each.state.covariance).all() for each in told)


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [10.0, 3.0])
def test_kept_factors_cost_a_lag_no_more_than_the_newest(rate_hz: float) -> None:
    sensors = ["accel", "gyro", "camera"]
    model = pm.pen_model("reference", sensors)
    recording = pm.simulate("reference", sensors, motion="handwriting", duration_s=3.0, seed=6)
    used = thinned(model, recording, CameraThinning(rate_hz, 0))
    kept, full = (
        run(create_estimator("mhe-rti", model, horizon=26, lag_samples=14, **reuse), used)
        for reuse in ({}, {"reuse_threshold": 0.0})
    )
    assert np.median(kept.reused_stages) > 10
    rms = {}
    for lag in (0, 14):
        one, other = (history.at_lag(lag)[50:] for history in (kept, full))
        off = model.difference(one.mean.T, other.mean.T).full().T / other.std
        rms[lag] = np.sqrt((off**2).mean(axis=0)).max()
        assert np.abs(one.std / other.std - 1).max() < 0.01
    assert rms[14] < 1.25 * rms[0]
    assert rms[14] < 0.02


@pytest.mark.parametrize("kind", [MheConfig, MheRtiConfig])
def test_what_makes_no_sense_is_refused(kind: type[Any]) -> None:
    assert kind(lag_samples=14).lags == (14,)
    assert kind(lag_samples=[5, 0, 5, 2]).lags == (2, 5)
    with pytest.raises(InputError, match="longer than the window's horizon, expected at most 13"):
        kind(horizon=13, lag_samples=14)
    for wrong in (-1, 2.5, True, "14", None):
        with pytest.raises(InputError, match=r"lag_samples is .*, expected whole numbers"):
            kind(lag_samples=wrong)


def test_a_history_without_that_lag_says_so() -> None:
    model, measurements = draw("pendulum")
    history = run_measurements(create_estimator("mhe", model, lag_samples=3), measurements)
    with pytest.raises(InputError, match="no estimates at lag 4, expected one of 0, 3: "):
        history.at_lag(4)
    part = history[5:12].at_lag(3)
    np.testing.assert_array_equal(part.time_s, [m.time_s for m in measurements[2:9]])
    assert np.isnan(part.innovation).all()
    assert not part.to_pandas().isna().to_numpy().any()
