"""Wrong starts on the turntable: every end recognised, none averaged into another."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from benchmark.configurations import TURNTABLE_CONFIGURATIONS
from estimation.kalman_stage import KalmanStage
from models.arrays import Array
from models.errors import InputError
from models.priors import replaced_prior
from models.turntable import mirror, paper_turntable, turntable_model
from pen_mhe.estimators import settings_read
from recordings.simulate_turntable import simulate_table
from suites.pen.turntable_starts import (
    OUTCOMES,
    StartRun,
    StartTrial,
    run_start,
    start_estimator,
)
from tests.models.test_turntable import equation_10

DEG = math.pi / 180
SIXTY = 60 * DEG
QUICK = {"horizon": 5}
DURATION_S = {"ekf": 2.0, "mhe": 0.4}
SIXTY_SEEDS = {"ekf": range(6), "mhe": (0, 5, 19)}
"""Seeds among which a start from 60° ends at the truth, and one in the mirror."""


def trial(configuration: str, estimator: str, start_error_rad: float) -> StartTrial:
    duration_s = DURATION_S[estimator]
    return StartTrial(
        configuration,
        estimator,
        start_error_rad,
        duration_s,
        duration_s / 4,
        settings=settings_read(estimator, QUICK),
    )


def all_runs(of: StartTrial, seeds: Iterable[int]) -> list[StartRun]:
    estimator = start_estimator(of)
    return [run_start(of, seed, estimator=estimator) for seed in seeds]


def true_start(duration_s: float, seed: int) -> Array:
    truth = simulate_table(paper_turntable(), duration_s, seed).truth
    assert truth is not None
    return truth.values[0]


@pytest.mark.cover
@pytest.mark.parametrize("estimator", DURATION_S)
@pytest.mark.parametrize("configuration", TURNTABLE_CONFIGURATIONS)
@pytest.mark.parametrize("seed", [1, 3])
def test_a_run_started_at_the_mirror_is_a_mirror_run(
    estimator: str, configuration: str, seed: int
) -> None:
    """It cannot leave: nothing that it is told speaks against the mirror."""
    small = trial(configuration, estimator, 2 * DEG)
    truth = true_start(small.duration_s, seed)
    run = run_start(small, seed, start_error_rad=mirror(truth)[:2] - truth[:2])
    assert run.outcome == "mirror"
    assert np.abs(run.error[:, 1]).min() > 170 * DEG
    assert np.abs(run.mirror_error[run.judged][:, :2]).max() < 3 * DEG


@pytest.mark.parametrize("estimator", DURATION_S)
@pytest.mark.parametrize("configuration", TURNTABLE_CONFIGURATIONS)
@pytest.mark.parametrize("seed", [1, 3])
def test_a_run_started_at_the_truth_converges(
    estimator: str, configuration: str, seed: int
) -> None:
    run = run_start(trial(configuration, estimator, 0.0), seed)
    assert np.array_equal(run.start_error_rad, [0.0, 0.0])
    assert run.outcome == "converged"
    assert np.abs(run.error[run.judged][:, :2]).max() < 3 * DEG


@pytest.mark.parametrize("estimator", DURATION_S)
def test_a_gyroscope_alone_does_not_find_the_truth(estimator: str) -> None:
    """It is sensitive to the start: φ stays as wrong as it was, whatever the readings."""
    runs = all_runs(trial("gyro", estimator, SIXTY), range(2))
    assert [run.outcome for run in runs] == ["lost", "lost"]
    for run in runs:
        assert run.error[0, 0] == pytest.approx(run.start_error_rad[0], abs=1e-9)
        assert np.abs(run.error[:, 0]).min() > 30 * DEG


@pytest.mark.cover
@pytest.mark.parametrize("estimator", DURATION_S)
@pytest.mark.parametrize("configuration", ["accel", "accel+gyro"])
def test_from_sixty_degrees_mirror_runs_are_recognised(estimator: str, configuration: str) -> None:
    """Runs settle where gravity is as measured; with cosφ of the wrong sign, in the mirror."""
    sixty = trial(configuration, estimator, SIXTY)
    runs = all_runs(sixty, SIXTY_SEEDS[estimator])
    assert {"mirror", "converged"} <= {run.outcome for run in runs} <= set(OUTCOMES)
    for run in runs:
        assert run.solved_fraction == 1.0
        assert np.abs(run.start_error_rad) == pytest.approx([SIXTY] * 2, rel=1e-12)
        truth = simulate_table(sixty.table, sixty.duration_s, run.seed).truth
        assert truth is not None
        true, estimated = truth.values[-1], truth.values[-1] + run.error[-1]
        sees_gravity = np.abs(equation_10(estimated) - equation_10(true)).max() < 0.3
        same_side = np.cos(true[0]) * np.cos(estimated[0]) > 0
        if run.outcome == "lost":
            # Only close to cosφ = 0, where a first step that was too long is forgotten slowly.
            assert np.abs(np.cos(truth.values[:, 0])).min() < np.sin(20 * DEG)
        else:
            assert sees_gravity
            assert run.outcome == ("converged" if same_side else "mirror")


@pytest.mark.cover
@pytest.mark.parametrize("degrees_beyond", [32.0, 36.0, 40.0])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_start_beyond_the_pole_may_end_in_the_mirror(degrees_beyond: float, sign: float) -> None:
    """Or find back: a first update that is settled at its own posterior sees both sides.

    The truth starts that far before φ = 90°, the estimate as much beyond as makes 60°.
    """
    phi = (90 - degrees_beyond, 90 - degrees_beyond + 0.1)
    table = paper_turntable()
    axis = table.tilt_phi.model_copy(
        update={"range_rad": (phi[0] * DEG, phi[1] * DEG), "rate_rad_s": 0.05 * DEG}
    )
    slow = replace(trial("accel", "ekf", SIXTY), table=table.model_copy(update={"tilt_phi": axis}))
    beyond = run_start(slow, 0, SIXTY * np.array([1.0, sign])).outcome
    assert beyond in ("mirror", "converged")
    assert run_start(slow, 0, SIXTY * np.array([-1.0, sign])).outcome == "converged"


@pytest.mark.parametrize("seed", range(4))
def test_first_step_of_a_linearised_update(seed: int) -> None:
    """θ turns by sin(θ - θ̂) cosφ / cosφ̂, but for the noise of one reading (5 σ).

    Of one update that is linearised at the start, as the EKF's would be if it did not settle.
    """
    sixty = trial("accel", "ekf", SIXTY)
    true = true_start(sixty.duration_s, seed)
    run = run_start(sixty, seed)
    model = turntable_model(paper_turntable(), ["accel"])
    phi, phi_start = true[0], true[0] + run.start_error_rad[0]
    start = replaced_prior(
        model,
        dict(zip(model.state_names[:2], true[:2] + run.start_error_rad, strict=True)),
        SIXTY,
    )
    recording = simulate_table(paper_turntable(), sixty.duration_s, seed)
    first = KalmanStage(model).update(start, next(iter(recording.measurements(model))).y)
    step = first.state.mean[1] - start.mean[1]
    expected = np.sin(-run.start_error_rad[1]) * np.cos(phi) / np.cos(phi_start)
    noise = model.noise_std[0] / 9.81
    off = math.remainder(step - expected, 2 * math.pi)
    assert abs(off) < 5 * noise / abs(np.cos(phi_start))


def test_the_signs_of_a_seed_are_the_same_for_every_size() -> None:
    sizes = [run_start(trial("gyro", "ekf", size), 5) for size in (20 * DEG, SIXTY)]
    assert sizes[1].start_error_rad == pytest.approx(3 * sizes[0].start_error_rad)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"configuration": "camera"}, "configuration camera is unknown, expected one of accel"),
        ({"start_error_rad": -0.1}, "start_error_rad is -0.1, expected 0 or more"),
        ({"start_error_rad": math.nan}, "start_error_rad is nan, expected 0 or more"),
        ({"judged_s": 6.0}, "judged_s is 6.0, expected between 0 and duration_s 5.0"),
        ({"limit_rad": 2.0}, "limit_rad is 2.0, expected between 0 and a quarter turn"),
    ],
)
def test_wrong_trials(change: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(StartTrial("accel", "ekf", SIXTY), **change)  # type: ignore[arg-type]


def test_unknown_estimator() -> None:
    with pytest.raises(InputError, match="estimator guess is unknown"):
        run_start(replace(trial("accel", "ekf", 0.0), estimator="guess"), 0)
