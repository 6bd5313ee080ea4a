"""Weights, found on a recording that is not judged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from classical_baseline.fixed_weight import FixedWeightConfig, run
from classical_baseline.weight_search import (
    CURVE_WEIGHTS,
    WeightSearch,
    best_weight,
    search_weight,
    weight_curve,
)
from models.arrays import Array
from suites.tilt.samples import TiltSamples, case_named, simulate_samples
from suites.tilt.scores import ERRORS

TRAINING = np.random.SeedSequence(0, spawn_key=tuple(b"training of the weight"))
"""Root of the training recordings: no seed of a task has it."""


@dataclass(frozen=True, eq=False)
class TrainedWeights:
    """What the training recording of a case says.

    Parameters
    ----------
    searched : by bisection over [0, 1], as published
    curve : RMS errors, deg, at `CURVE_WEIGHTS`
    """

    searched: WeightSearch
    curve: Array

    @property
    def best(self) -> float:
        """The weight of the curve's smallest error."""
        return best_weight(CURVE_WEIGHTS, self.curve)


@cache
def trained_weights(case: str) -> TrainedWeights:
    """Search the weights for a case."""
    samples = simulate_samples(case_named(case), TRAINING)

    def rmse(weight: float) -> float:
        return weight_rmse_deg(case, samples, weight)

    return TrainedWeights(search_weight(rmse), weight_curve(rmse))


def weight_rmse_deg(case: str, samples: TiltSamples, weight: float) -> float:
    """Return the RMS of the error by which weights are chosen in a case."""
    errors = ERRORS[case_named(case).weighed_by](samples, fused(samples, FixedWeightConfig(weight)))
    return float(np.sqrt(np.mean(errors**2)))


def fused(samples: TiltSamples, config: FixedWeightConfig) -> Array:
    """Return the direction (n, 3) that the recursion finds."""
    return run(config, samples.time_s, samples.acceleration_g, samples.rates)
