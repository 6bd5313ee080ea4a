"""One contender on one problem, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType

import numpy as np

from benchmark.tasks.task import Outcome, Quantity, Series, Task
from estimation.recording import Recording
from models.arrays import Array
from models.gaussian import GaussianState
from suites.classics import do_mpc
from suites.classics.contender import ClassicContender, Estimates, OwnContender
from suites.classics.kalman import filtered
from suites.classics.problem import ClassicProblem
from suites.classics.problems import figures_of, problem_named
from suites.classics.recordings import SENSOR, model_of, prior_of, recorded

PEERS: Mapping[str, Callable[[str], ClassicContender]] = MappingProxyType(
    {do_mpc.NAME: do_mpc.DoMpcEstimator}
)
"""Contenders of others: case → contender."""
DEVIATIONS = 3.0
"""An error within so many claimed deviations is one that the estimator knew of."""
WITHIN = "samples within 3 deviations"
RUN_WITHIN = "run within 3 deviations"
SOLVED, SUCCESS = "finite and solved", "success"
"""Quantities of a run: fractions of its samples, and 1 or 0."""
FROM_FILTER, UNFORCED = "from the Kalman filter", "{} of a Kalman filter without the inputs"
"""Of a linear problem: what is away from a filter that knows its inputs; one that does not."""
SAME_FILTER = 1e-9
"""In the units of the states: up to here an estimator is the Kalman filter."""


def run_problem(task: Task) -> Outcome:
    """Run one task."""
    recording = recorded(task.case, task.seed)
    prior = prior_of(task.case, recording, task.seed)
    found = _contender(task.estimator, task.case).estimates(recording, prior)
    return Outcome(
        model_of(task.case).name,
        tuple(quantities(task.case, recording, prior, found)),
        len(recording.time_s),
        float(found.is_solved.mean()),
        float(np.median(found.step_time_s)),
        float(np.quantile(found.step_time_s, 0.99)),
        series=(_series(task.case, recording, found),) if task.seed == 0 else (),
    )


def quantities(
    case: str, recording: Recording, prior: GaussianState, found: Estimates
) -> list[Quantity]:
    """Return errors of the judged state behind `from_s`, and what is counted.

    Parameters
    ----------
    prior : that the estimates began from
    """
    problem, shown = problem_named(case), _series(case, recording, found)
    assert shown.std is not None
    assert shown.truth is not None
    judged = shown.time_s >= problem.from_s - 1e-9
    errors = (shown.estimate - shown.truth)[judged]
    claimed = shown.std[judged] if found.claims else None
    told = [
        _errors(problem.judged, shown.unit, errors, claimed),
        Quantity.single(SOLVED, "1", float((found.is_finite & found.is_solved).mean())),
    ]
    if claimed is not None:
        with np.errstate(all="ignore"):  # a claimed deviation of 0 is one more error
            told += _beside_claimed(errors / claimed)
    if problem.succeeds_below is not None:
        limit = problem.succeeds_below(figures_of(case))
        told.append(_verdict(SUCCESS, _rms(errors) <= limit))
    if problem.is_linear:
        told += _beside_filter(problem, case, recording, prior, found.mean)
    return told


def _series(case: str, recording: Recording, found: Estimates) -> Series:
    """Return the judged state over time."""
    problem, truth = problem_named(case), recording.truth
    assert truth is not None
    i = list(problem.states).index(problem.judged)
    of_state = (found.mean[:, i], found.std[:, i], truth.values[:, i])
    return Series(problem.judged, problem.states[problem.judged], recording.time_s, *of_state)


@cache
def _contender(name: str, case: str) -> ClassicContender:
    return PEERS[name](case) if name in PEERS else OwnContender(name, case)


def _beside_claimed(errors: Array) -> list[Quantity]:
    """Return what is within 3 deviations, of errors (n,) in deviations: samples, and the run."""
    return [
        Quantity.single(WITHIN, "1", float((np.abs(errors) <= DEVIATIONS).mean())),
        _verdict(RUN_WITHIN, _rms(errors) <= DEVIATIONS),
    ]


def _beside_filter(
    problem: ClassicProblem, case: str, recording: Recording, prior: GaussianState, mean: Array
) -> list[Quantity]:
    """Return how far means (n, n_x) are from a Kalman filter, and what one without inputs errs."""
    assert recording.truth is not None
    given, y = figures_of(case), recording.readings[SENSOR][:, 0]
    (force,) = recording.inputs.values()
    away = np.abs(mean - filtered(prior, y, force, given)).max(axis=1)
    i = list(problem.states).index(problem.judged)
    unforced = filtered(prior, y, 0 * force, given)[:, i] - recording.truth.values[:, i]
    return [
        _errors(FROM_FILTER, "", away),
        _verdict(SUCCESS, bool((away <= SAME_FILTER).all())),
        _errors(UNFORCED.format(problem.judged), problem.states[problem.judged], unforced),
    ]


def _verdict(name: str, holds: bool) -> Quantity:
    return Quantity.single(name, "1", float(holds))


def _rms(errors: Array) -> float:
    with np.errstate(over="ignore"):
        return float(np.sqrt((errors**2).mean()))


def _errors(name: str, unit: str, errors: Array, claimed: Array | None = None) -> Quantity:
    """Return errors as a quantity; of a run that ended in NaN they are infinite, not left out."""
    whole = np.where(np.isfinite(errors), errors, np.inf)
    with np.errstate(invalid="ignore"):
        return Quantity.of_errors(name, unit, whole, claimed=claimed)
