"""The stream on which filters run: one sample after the other, and what this EKF makes of it.

Every filter carries its own state from sample to sample, so all see the same readings and,
if they are right, the same states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimation.estimator import run_measurements
from estimation.recording import Measurement
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel
from pen_mhe.estimators import create_estimator
from suites.speed.problems import Problem
from suites.speed.windows import recorded


@dataclass(frozen=True, eq=False)
class Sample:
    """One instant of a stream: its number and its readings."""

    index: int
    measurement: Measurement


@dataclass(frozen=True, eq=False)
class SampleStream:
    """A whole stream as one item: instants (n,) s and readings (n, n_y)."""

    time_s: Array
    y: Array


@dataclass(frozen=True, eq=False)
class FilteredStream:
    """A stream, and x_k|k of this EKF at each of its samples."""

    samples: tuple[Sample, ...]
    reference: tuple[GaussianState, ...]

    @property
    def whole(self) -> SampleStream:
        """The stream as one item."""
        taken = [sample.measurement for sample in self.samples]
        return SampleStream(np.array([m.time_s for m in taken]), np.array([m.y for m in taken]))


def filtered_stream(problem: Problem, model: StateSpaceModel, count: int) -> FilteredStream:
    """Return the first samples of a problem's recording."""
    measurements = recorded(problem, model, count)
    history = run_measurements(
        create_estimator("ekf", model, huber={}), measurements, covariances=True
    )
    states = map(GaussianState, history.mean, history.covariance)
    return FilteredStream(tuple(map(Sample, range(count), measurements)), tuple(states))
