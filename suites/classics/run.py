"""One estimator on one problem, and what is said of it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from benchmark.tasks.task import Outcome, Quantity, Series, Task
from estimation.estimator import Estimator, run
from models.arrays import Array
from pen_mhe.estimators import create_estimator, settings_read
from suites.classics.problems import model_of, problem_named, recorded, settings

DEVIATIONS = 3.0
"""An error within so many claimed deviations is one that the estimator knew of."""
WITHIN, FINITE, SUCCESS = "within 3 deviations", "finite", "success"
"""Quantities of a run: fractions of its samples, and 1 or 0."""
SUCCESS_BELOW = {"gas_2A_to_B": 0.2, "gas_A_B_C": 0.01}
"""Case → RMS of the judged state up to which a run succeeds."""


def run_problem(task: Task) -> Outcome:
    """Run one task: errors of the judged state behind `from_s`, and what is counted."""
    problem, model = problem_named(task.case), model_of(task.case)
    recording = recorded(task.case, task.seed)
    history = run(_estimator(task.estimator, task.case), recording)
    assert recording.truth is not None
    i = problem.states.index(problem.judged)
    estimate, std, truth = history.mean[:, i], history.std[:, i], recording.truth.values[:, i]
    finite = np.isfinite(history.mean).all(axis=1) & np.isfinite(history.std).all(axis=1)
    judged = history.time_s >= problem.from_s - 1e-9
    errors = estimate - truth
    quantities = [
        _errors(problem.judged, errors[judged], std[judged]),
        Quantity.single(WITHIN, "1", float((np.abs(errors) <= DEVIATIONS * std)[judged].mean())),
        Quantity.single(FINITE, "1", float(finite.mean())),
    ]
    if task.case in SUCCESS_BELOW:
        rms = float(np.sqrt((errors[judged] ** 2).mean()))
        quantities.append(Quantity.single(SUCCESS, "1", float(rms <= SUCCESS_BELOW[task.case])))
    return Outcome(
        model.name,
        tuple(quantities),
        len(history),
        history.solved_fraction,
        float(np.median(history.step_time_s)),
        float(np.quantile(history.step_time_s, 0.99)),
        series=(Series(problem.judged, "", history.time_s, estimate, std, truth),)
        if task.seed == 0
        else (),
    )


@cache
def _estimator(name: str, case: str) -> Estimator[Any]:
    return create_estimator(name, model_of(case), **settings_read(name, settings(case)))


def _errors(name: str, errors: Array, std: Array) -> Quantity:
    """Return errors as a quantity; of a run that ended in NaN they are infinite, not left out."""
    whole = np.where(np.isfinite(errors), errors, np.inf)
    with np.errstate(invalid="ignore"):
        return Quantity.of_errors(name, "", whole, claimed=std)
