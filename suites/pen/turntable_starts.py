"""Bad starts on the turntable: who finds the truth, who settles in its mirror.

What an accelerometer and a gyroscope read is the same at (φ, θ) and at the mirror state
(π - φ, θ + π), where the table is turned half a turn about the vertical (see
`models.turntable.mirror`). Truth and mirror lie on opposite sides of cosφ = 0. Far from
the truth a linearised update turns θ by about sin(θ - θ̂) cosφ / cosφ̂: a start φ̂ beyond
cosφ = 0 is on the mirror's side, and turns θ the wrong way, towards the mirror; close to
cosφ = 0 the same step is also far too long, and can reach the mirror from either side.
Once there, only the prior speaks against it: innovations are as small as at the truth,
and a filter's covariance has long forgotten the prior. An optimiser that starts from the
prior mean descends into the same two valleys, although from 60° the truth is the better
optimum (½·2 for one standard deviation in each angle; the mirror is at least 120° off in
θ, ½·4). So a run in the mirror is neither a success nor a failure of the sensors: it is
counted apart, and never averaged into an error. Runs are lost with a gyroscope alone,
which does not see φ, and for some seconds close to cosφ = 0, where a first step that was
too long is forgotten slowly.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchmark.configurations import TURNTABLE_CONFIGURATIONS
from estimation.estimator import Estimator, run
from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.names import unknown
from models.priors import replaced_prior
from models.random_streams import seed_sequence, stream
from models.turntable import TurntableConfig, mirror, paper_turntable, turntable_model
from pen_mhe.errors import state_errors
from pen_mhe.estimators import create_estimator
from recordings.simulate_turntable import simulate_table

OUTCOMES = ("converged", "mirror", "lost")
"""At the truth, at its mirror, at neither."""

SMALLEST_START_STD_RAD = math.radians(1.0)
"""What an estimator is told of a start without error."""


@dataclass(frozen=True)
class StartTrial:
    """One estimator, started wrong by a given size.

    Parameters
    ----------
    configuration : one of `benchmark.configurations.TURNTABLE_CONFIGURATIONS`
    estimator : one of `pen_mhe.estimators.ESTIMATORS`
    start_error_rad : error of the prior mean in φ and in θ, each with a drawn sign, and
        standard deviation of the prior (at least `SMALLEST_START_STD_RAD`)
    duration_s : of a run; longer lets more runs settle
    judged_s : the end of a run by which it is judged
    limit_rad : RMS error of φ and of θ below which a run has settled, below a quarter turn;
        larger calls fewer runs lost
    settings : of the estimator, by name
    table : the turntable; both its axes run at their rates

    Raises
    ------
    InputError
        If the configuration is unknown, or a number is outside its range.
    """

    configuration: str
    estimator: str
    start_error_rad: float
    duration_s: float = 5.0
    judged_s: float = 1.0
    limit_rad: float = math.radians(10.0)
    settings: Mapping[str, Any] = field(default_factory=dict)
    table: TurntableConfig = field(default_factory=paper_turntable)

    def __post_init__(self) -> None:
        if self.configuration not in TURNTABLE_CONFIGURATIONS:
            raise unknown("turntable configuration", self.configuration, TURNTABLE_CONFIGURATIONS)
        if not 0 <= self.start_error_rad < math.inf:
            raise InputError(f"start_error_rad is {self.start_error_rad}, expected 0 or more")
        if not 0 < self.judged_s <= self.duration_s:
            raise InputError(
                f"judged_s is {self.judged_s}, expected between 0 and duration_s {self.duration_s}"
            )
        if not 0 < self.limit_rad < math.pi / 2:
            raise InputError(
                f"limit_rad is {self.limit_rad}, expected between 0 and a quarter turn"
            )


@dataclass(frozen=True, eq=False)
class StartRun:
    """One run and what became of it.

    Parameters
    ----------
    seed : of the recording and of the start's signs
    start_error_rad : (2,) prior mean minus truth, φ and θ
    outcome : one of `OUTCOMES`
    time_s : (n,)
    error, mirror_error : (n, n_x) estimate minus truth, and minus the truth's mirror
    judged : (n,) true at the instants by which it was judged
    solved_fraction : of its steps
    step_time_s : (n,)
    """

    seed: int
    start_error_rad: Array
    outcome: str
    time_s: Array
    error: Array
    mirror_error: Array
    judged: Array
    solved_fraction: float
    step_time_s: Array


def start_estimator(trial: StartTrial) -> Estimator[Any]:
    """Return the estimator of a trial, which serves all its starts and seeds."""
    sensors = TURNTABLE_CONFIGURATIONS[trial.configuration].sensors
    model = turntable_model(trial.table, sensors)
    return create_estimator(trial.estimator, model, **trial.settings)


def run_start(
    trial: StartTrial,
    seed: int,
    start_error_rad: Array | None = None,
    estimator: Estimator[Any] | None = None,
    *,
    recording: Recording | None = None,
) -> StartRun:
    """Run one estimator from one wrong start and judge where it ends.

    Parameters
    ----------
    start_error_rad : (2,) error of the prior mean; the trial's size with drawn signs by
        default. The prior's standard deviation is the trial's either way
    estimator : of `start_estimator`, where there is one already
    recording : of the seed, where it is simulated already
    """
    estimator = estimator or start_estimator(trial)
    model = estimator.model
    if recording is None:
        recording = simulate_table(trial.table, trial.duration_s, seed)
    truth = recording.truth
    assert truth is not None
    if start_error_rad is None:
        signs = stream(seed_sequence(seed), "signs of the start").choice([-1.0, 1.0], size=2)
        start_error_rad = trial.start_error_rad * signs
    tilts = truth.values[0, :2] + start_error_rad
    std = max(trial.start_error_rad, SMALLEST_START_STD_RAD)
    told = replaced_prior(model, dict(zip(model.state_names[:2], tilts, strict=True)), std)
    blind = replace(
        recording.select([sensor.name for sensor in model.measured_sensors]), truth=None
    )
    history = run(estimator, blind, prior=told)
    mirrored = Truth(truth.time_s, truth.names, mirror(truth.values))
    error, mirror_error = (state_errors(model, history, true) for true in (truth, mirrored))
    judged = history.time_s > history.time_s[-1] - trial.judged_s
    return StartRun(
        seed,
        start_error_rad,
        _outcome(error[judged], mirror_error[judged], trial.limit_rad),
        history.time_s,
        error,
        mirror_error,
        judged,
        history.solved_fraction,
        history.step_time_s,
    )


def _outcome(error: Array, mirror_error: Array, limit_rad: float) -> str:
    """Return which solution both tilts have settled in, from the judged errors (n, n_x)."""
    for outcome, errors in (("converged", error), ("mirror", mirror_error)):
        if np.sqrt(np.mean(errors[:, :2] ** 2, axis=0)).max() <= limit_rad:
            return outcome
    return "lost"
