"""Monte Carlo consistency: many runs with known truth, NEES and NIS of each estimator.

Each case draws its truth anew for every seed. Where it is drawn from the model itself,
a consistent estimator has a mean NEES of n_x and a mean NIS per row of 1; the
standard error is taken across runs, because the instants of one run are not
independent. Where the truth is handwriting, the model's motion does not drive it: the
figures show what that motion is worth, they prove nothing.

The first instants are counted apart, up to `SETTLED_S`. An update that is linearised where
the prior has the pen at rest knows nothing of ω²r, which at a rate of 1 rad/s is 0.16 m/s²,
several times the accelerometer's noise: its first NEES is far out. Later ones know the rate.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from estimation.consistency import nees, nis
from estimation.estimate import EstimateHistory
from estimation.estimator import Estimator, run
from estimation.recording import Recording
from estimation.true_error import true_errors
from models.arrays import Array
from models.motion import AttitudeWhiteJerk
from models.names import unknown
from models.pen import pen_model
from models.pen_config import PenConfig, Prior
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate, simulate_model


@dataclass(frozen=True)
class ConsistencyCase:
    """Where the truth comes from and how well its start is known.

    Parameters
    ----------
    label : for tables
    motion : ``model`` draws the truth from the model, else a name of `models.motions.motions`
    prior : changes of the pen's prior, its fields by name
    duration_s : of each run
    """

    label: str
    motion: str
    prior: Mapping[str, float]
    duration_s: float = 1.0


def _angles(std_deg: float) -> dict[str, float]:
    return {f"{name}_std_rad": np.radians(std_deg) for name in ("azimuth", "elevation", "spin")}


SETTLED = {
    **_angles(1.0),
    "elevation_rad": 0.9,
    "angle_rate_std_rad_s": 0.1,
    "acceleration_std_m_s2": 0.3,
    "angle_acceleration_std_rad_s2": 2.0,
}
"""A pen whose attitude is known to 1° and which hardly moves yet."""

CASES: Mapping[str, ConsistencyCase] = MappingProxyType(
    {
        "settled": ConsistencyCase("drawn from the model, start known to 1°", DRAWN, SETTLED),
        "moving": ConsistencyCase(
            "drawn from the model, start known to 1°, already moving",
            DRAWN,
            {**_angles(1.0), "elevation_rad": 0.9},
        ),
        "picked-up": ConsistencyCase(
            "drawn from the model, start known to 10°, already moving",
            DRAWN,
            {**_angles(10.0), "elevation_rad": 0.9},
        ),
        "handwriting": ConsistencyCase("smooth handwriting", "handwriting", {}, 3.0),
    }
)
"""Name → case."""

SETTLED_S = 0.2
"""Earlier instants are counted apart."""

EULER_JERK = 10.0
"""rad/s³/√Hz of a pen without spin in all that are drawn from the model: its own would soon turn
it through the upright, where Euler angles are singular. A free pen keeps its own motion."""


@dataclass(frozen=True, eq=False)
class ConsistencyRuns:
    """Statistics of many runs.

    Parameters
    ----------
    n_x : number of states, the expected NEES
    nees : (runs,) mean NEES of each run, from `SETTLED_S` on
    first_nees : (runs,) NEES at the first instant
    nis_per_row : (runs,) mean NIS of each run per present row, expected 1
    state_error : (runs,) error over its deviation, RMS over states and instants from
        `SETTLED_S` on, expected 1: of each state by itself, where NEES judges all together
    """

    n_x: int
    nees: Array
    first_nees: Array
    nis_per_row: Array
    state_error: Array

    @property
    def standard_error(self) -> float:
        """Standard error of the mean NEES across runs, at most √(2 n_x / runs).

        A consistent estimator's is never larger (it is that where a run is one draw of
        χ²); a larger one comes from a heavy tail, which would excuse any mean. A single run
        has no other.
        """
        n = len(self.nees)
        largest = float(np.sqrt(2 * self.n_x / n))
        return min(float(self.nees.std(ddof=1) / np.sqrt(n)), largest) if n > 1 else largest

    @property
    def deviation(self) -> float:
        """(mean NEES - n_x) in standard errors."""
        return float((self.nees.mean() - self.n_x) / self.standard_error)


def case_pen(pen: PenConfig, case: ConsistencyCase) -> PenConfig:
    """Return the pen of a case: its prior, and `EULER_JERK` where that is drawn from."""
    prior = Prior.model_validate({**pen.prior.model_dump(), **case.prior})
    motion = pen.motion
    if case.motion == DRAWN and pen.degrees_of_freedom == 5:
        jerk = AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=EULER_JERK)
        motion = motion.model_copy(update={"attitude": jerk})
    return pen.model_copy(update={"prior": prior, "motion": motion})


def case_named(name: str) -> ConsistencyCase:
    """Return a case of the table; raises `InputError` for an unknown one."""
    if name not in CASES:
        raise unknown("case", name, CASES)
    return CASES[name]


@dataclass(frozen=True, eq=False)
class ConsistencyBench:
    """A case with its model and one estimator, which serve all of its runs.

    Parameters
    ----------
    pen : with the case's prior
    sensors : names from the pen file; None takes all that can be simulated
    """

    pen: PenConfig
    sensors: Sequence[str] | None
    case: ConsistencyCase
    model: StateSpaceModel
    estimator: Estimator[Any]

    def recording(self, seed: int) -> Recording:
        """Return the recording of a seed, with its truth."""
        if self.case.motion == DRAWN:
            return simulate_model(self.model, duration_s=self.case.duration_s, seed=seed)
        return simulate(
            self.pen,
            self.sensors,
            motion=self.case.motion,
            duration_s=self.case.duration_s,
            seed=seed,
        )

    def run(self, seed: int) -> tuple[EstimateHistory, Array, Array]:
        """Return the estimates of a seed, their NEES (n,) and errors over deviations (n, n_x)."""
        recording = self.recording(seed)
        assert recording.truth is not None
        history = run(self.estimator, recording, covariances=True)
        states = recording.truth.states(self.model.state_names, history.time_s)
        errors = true_errors(self.model, history.mean, states)
        return history, nees(self.model, history, states), errors / history.std

    def statistics(self, runs: Iterable[tuple[EstimateHistory, Array, Array]]) -> ConsistencyRuns:
        """Return the statistics of some runs of `run`."""
        figures = []
        for history, of_run, ratios in runs:
            squared, rows = nis(history, self.model.measured_rows)
            later = history.time_s >= history.time_s[0] + SETTLED_S
            rms = np.sqrt(np.mean(ratios[later] ** 2))
            figures.append((of_run[later].mean(), of_run[0], np.nansum(squared) / rows.sum(), rms))
        return ConsistencyRuns(self.model.n_x, *np.array(figures).T)


def bench(
    pen: PenConfig,
    sensors: Sequence[str] | None,
    case: ConsistencyCase,
    estimator: str,
    settings: Mapping[str, Any] | None = None,
) -> ConsistencyBench:
    """Build the model and the estimator of a case."""
    pen = case_pen(pen, case)
    # A truth that is drawn knows of no writing area.
    model = pen_model(pen, sensors, writing_area=case.motion != DRAWN)
    return ConsistencyBench(
        pen, sensors, case, model, create_estimator(estimator, model, **(settings or {}))
    )


def run_case(
    pen: PenConfig,
    sensors: Sequence[str] | None,
    case: ConsistencyCase,
    estimator: str,
    seeds: Iterable[int],
    settings: Mapping[str, Any] | None = None,
) -> ConsistencyRuns:
    """Run one estimator on the recordings of one case, one per seed."""
    built = bench(pen, sensors, case, estimator, settings)
    return built.statistics(map(built.run, seeds))
