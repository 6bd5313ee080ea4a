"""A task of the benchmark, and what it found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array

OK, FAILED = "ok", "failed"
"""Status of a task that has figures, and of one that broke off; a suite may have more."""


@dataclass(frozen=True, order=True)
class Task:
    """One run of one estimator on one recording. All its randomness follows from these fields.

    Parameters
    ----------
    suite : a name of the table of suites
    case : of the suite: a motion, a start, a camera rate
    sensors : name of the configuration
    estimator : its name
    seed : of the recording
    """

    suite: str
    case: str
    sensors: str
    estimator: str
    seed: int

    @property
    def key(self) -> str:
        """The fields as one text."""
        return "/".join((self.suite, self.case, self.sensors, self.estimator, str(self.seed)))


@dataclass(frozen=True)
class Quantity:
    """The error of one quantity over a run.

    A figure that a run has only one of (a settling time) is a quantity of one sample: its
    `bias` is the figure itself, `rmse` and `max_error` its size.

    Parameters
    ----------
    name : ``elevation``, ``tip``; see the suite
    unit : of the errors: ``deg``, ``mm``
    rmse, bias, max_error : root mean square, mean, largest size; infinite where a figure is
        never reached
    observable : False: the sensors do not show it, and the error would only show the prior
    claimed : root mean square of the standard deviation that the estimator claims; None where
        it claims none, or the quantity is no error of an estimate
    """

    name: str
    unit: str
    rmse: float
    bias: float
    max_error: float
    observable: bool = True
    claimed: float | None = None

    @classmethod
    def of_errors(
        cls,
        name: str,
        unit: str,
        errors: Array,
        observable: bool = True,
        *,
        claimed: Array | None = None,
    ) -> Quantity:
        """Return the quantity of errors (n,), estimate minus truth, or (n, k) of a vector.

        A vector's errors are lengths: its bias is the length of the mean error.

        Parameters
        ----------
        claimed : standard deviations of the shape of `errors`; a vector's add up as variances
        """
        rows = np.asarray(errors, dtype=float).reshape(len(errors), -1)
        squared, mean = (rows**2).sum(axis=1), rows.mean(axis=0)
        return cls(
            name,
            unit,
            float(np.sqrt(squared.mean())),
            float(mean[0] if rows.shape[1] == 1 else np.linalg.norm(mean)),
            float(np.sqrt(squared.max())),
            observable,
            None if claimed is None else float(np.sqrt(np.square(claimed).sum() / len(claimed))),
        )

    @classmethod
    def single(cls, name: str, unit: str, figure: float, observable: bool = True) -> Quantity:
        """Return a figure that a run has only one of."""
        return cls(name, unit, abs(figure), figure, abs(figure), observable)


@dataclass(frozen=True, eq=False)
class Series:
    """A quantity over time.

    Parameters
    ----------
    quantity, unit : as of a `Quantity`
    time_s : (n,)
    estimate : (n,)
    std : (n,) as claimed; None where the estimator claims none
    truth : (n,); None where there is none
    """

    quantity: str
    unit: str
    time_s: Array
    estimate: Array
    std: Array | None = None
    truth: Array | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a task found.

    Parameters
    ----------
    model : name of the model that the estimator used; empty without one
    quantities : errors and figures
    samples : number of estimates
    solved_fraction : of the steps; 1 for an estimator that cannot fail
    step_time_median_s, step_time_p99_s : of a step; the only entries that may differ
        between two runs of a task, but for quantities that are times (`Suite.is_timed`)
    status : `OK`, `FAILED`, or a word of the suite: ``mirror``
    reason : a sentence, where the status is not `OK`; else what the suite has to say of the run
    series : of seed 0, for figures
    """

    model: str
    quantities: tuple[Quantity, ...]
    samples: int
    solved_fraction: float
    step_time_median_s: float
    step_time_p99_s: float
    status: str = OK
    reason: str = ""
    series: tuple[Series, ...] = ()


def reason_of(error: Exception) -> str:
    """Return in a line what a task broke off with; a file's name may hold what no table can."""
    reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
    return reason.encode("utf-8", "replace").decode("utf-8")


def failed(reason: str) -> Outcome:
    """Return the outcome of a task that broke off."""
    nan = float("nan")
    return Outcome("", (), 0, 0.0, nan, nan, FAILED, reason)
