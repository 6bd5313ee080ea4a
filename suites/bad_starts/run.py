"""Bad starts of a pen: who finds the truth within the first second, and who never does.

An estimator is told a start whose elevation is wrong by a known amount, and a standard
deviation that says so. Gravity then shows the truth, but not linearly: at an error δ the
reading is off by about g δ²/2 (1.2 m/s² at 0.5 rad) from what a linearised update expects.
An EKF hands that remainder to whatever else may explain it, accelerations of the tip and
biases, and is sure of them from then on. An MHE looks at its first readings again, from
where it has got to. What is left of its error does not depend on the start: it is what the
sensors can say, given what else may happen (`suites.bad_starts.cases.KNOWLEDGE`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS
from estimation.estimator import Estimator, run
from models.arrays import Array
from models.pen import moving_pen
from models.pen_config import PenConfig
from models.priors import replaced_prior
from models.random_streams import seed_sequence, stream
from pen_mhe.estimators import create_estimator
from suites.bad_starts.cases import KNOWLEDGE, BadStart, case_model, case_pen, case_recording

if TYPE_CHECKING:
    import pandas as pd

ESTIMATORS = BENCHMARK_ESTIMATORS
"""What is compared by default."""

FIRST_S = 1.0
ELEVATION = "elevation_rad"

WITHIN_DEG = (1.0, 5.0)
"""A run counts as arrived where its last elevation is this near."""


@dataclass(frozen=True, eq=False)
class BadStartRun:
    """One run of one estimator.

    Parameters
    ----------
    seed : of motion, noise, biases and the start's sign
    start_error_rad : of the prior's elevation, with its sign
    time_s : (n,)
    elevation_error, elevation_std : (n,) rad; of the axis, see `axis_elevation`, and the
        state's standard deviation as claimed
    rate_error : (n,) rad/s, length of the error of the judged body rates
    solved_fraction : of the steps
    """

    seed: int
    start_error_rad: float
    time_s: Array
    elevation_error: Array
    elevation_std: Array
    rate_error: Array
    solved_fraction: float

    def first_rms(self, error: Array) -> float:
        """Return the RMS of an error (n,) over the first second."""
        return float(np.sqrt(np.mean(error[self.time_s <= self.time_s[0] + FIRST_S] ** 2)))


def run_bad_start(
    case: BadStart, estimator: str, seed: int, settings: Mapping[str, Any] | None = None
) -> BadStartRun:
    """Run one estimator from one wrong start.

    A seed is one recording and one start, the same for every estimator.
    """
    recording, pen, model = case_recording(case, seed), case_pen(case), case_model(case)
    truth = recording.truth
    assert truth is not None
    true = truth.states(model.state_names, recording.time_s)
    column = model.state_names.index(ELEVATION)
    sign = float(stream(seed_sequence(seed), "sign of the start").choice([-1.0, 1.0]))
    start_error = sign * case.wrong_rad
    told = replaced_prior(model, {ELEVATION: true[0, column] + start_error}, case.std_rad)
    blind = replace(recording, truth=None)  # no estimator is given the truth
    if settings is None:
        chosen = _kept(replace(case, label="", wrong_rad=0.0, told_std_rad=None), estimator)
    else:
        chosen = create_estimator(estimator, model, **(settings or {}))
    history = run(chosen, blind, prior=told)
    rate_error = body_rates(pen, history.mean) - body_rates(pen, true)
    judged = ["xyz".index(axis) for axis in case.rate_axes]
    return BadStartRun(
        seed,
        start_error,
        history.time_s,
        axis_elevation(history.mean[:, column]) - axis_elevation(true[:, column]),
        history.std[:, column],
        np.linalg.norm(rate_error[:, judged], axis=1),
        history.solved_fraction,
    )


@lru_cache(maxsize=16)
def _kept(case: BadStart, estimator: str) -> Estimator[Any]:
    """Return an estimator that serves every start of a case: one is slow to build."""
    return create_estimator(estimator, case_model(case))


def axis_elevation(theta: Array) -> Array:
    """Return how far the pen's axis is above the desk, -π/2 to π/2, for states θ (n,), rad.

    (φ, θ, ψ) and (φ + π, π - θ, ψ + π) are one attitude: a run that gets to know the pen as
    leaning over its top to the other side is not wrong.
    """
    return np.arcsin(np.sin(theta))


def body_rates(pen: PenConfig, states: Array) -> Array:
    """Return the body rates (n, 3), rad/s, of a pen's states (n, n_x)."""
    n = pen.degrees_of_freedom
    x = ca.SX.sym("x", states.shape[1])
    body = moving_pen(pen, x[:n], x[n : 2 * n], x[2 * n : 3 * n])
    rate = ca.Function("body_rate", [x], [ca.densify(body.rigid.body_rate())])
    return np.array(rate(states.T)).T


def summary(case: BadStart, estimator: str, runs: Iterable[BadStartRun]) -> dict[str, object]:
    """Return the row of a table: medians and 90th percentiles over the runs.

    ``…_rms_…`` are of the first second. At the end of the run: ``end_…`` is the error,
    ``within_…`` the fraction of runs that near, ``end_error_per_std`` the median of the
    error over its claimed standard deviation: 0.67 where that is honest and Gaussian.
    """
    runs = list(runs)
    end = np.abs([run.elevation_error[-1] for run in runs])
    claimed = np.array([run.elevation_std[-1] for run in runs])
    return {
        "case": case.label,
        "told": KNOWLEDGE[case.knowledge].label,
        "wrong_rad": case.wrong_rad,
        "told_std_rad": case.std_rad,
        "estimator": estimator,
        "runs": len(runs),
        **_quantiles("elevation_rms_rad", [run.first_rms(run.elevation_error) for run in runs]),
        **_quantiles("rate_rms_rad_s", [run.first_rms(run.rate_error) for run in runs]),
        "end_s": float(runs[0].time_s[-1]),
        **_quantiles("end_elevation_rad", end),
        **{f"within_{deg:g}_deg": float(np.mean(end <= np.radians(deg))) for deg in WITHIN_DEG},
        "end_error_per_std": float(np.median(end / claimed)),
        "solved": float(np.mean([run.solved_fraction for run in runs])),
    }


def _quantiles(name: str, values: Iterable[float]) -> dict[str, float]:
    median, p90 = np.quantile(list(values), [0.5, 0.9])
    return {f"{name}_median": float(median), f"{name}_p90": float(p90)}


def as_table(rows: Iterable[Mapping[str, object]]) -> pd.DataFrame:
    """Return rows of `summary` as a table."""
    import pandas as pd  # slow to import, for tables only

    return pd.DataFrame(list(rows))
