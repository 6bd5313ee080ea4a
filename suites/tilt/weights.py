"""Weights, found over recordings that are not judged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from classical_baseline.fixed_weight import FixedWeightConfig, run, weight_of_sum
from classical_baseline.weight_search import (
    CURVE_WEIGHTS,
    WeightSearch,
    best_weight,
    search_weight,
    weight_curve,
)
from models.arrays import Array
from suites.tilt.recursion import run_compiled
from suites.tilt.samples import TiltSamples, case_named, simulate_samples
from suites.tilt.scores import ERRORS

RECORDINGS = 10
TRAINING = np.random.SeedSequence(0, spawn_key=tuple(b"training of the weight"))
"""Root of the training recordings: no seed of a task has it."""


@dataclass(frozen=True, eq=False)
class TrainedWeights:
    """What the training recordings of a case say, together.

    Parameters
    ----------
    searched : by bisection over [0, 1], as published, of R_acc + w R_g
    searched_convex : likewise of (1 - w) R_acc + w R_g
    curves : RMS errors (n, m), deg, of n recordings at the m `CURVE_WEIGHTS`
    """

    searched: WeightSearch
    searched_convex: WeightSearch
    curves: Array

    @property
    def curve(self) -> Array:
        """RMS errors (m,) over all recordings."""
        return rms(self.curves)

    @property
    def best_of_each(self) -> list[float]:
        """The weight of the smallest error of every recording by itself."""
        return [best_weight(CURVE_WEIGHTS, curve) for curve in self.curves]

    @property
    def best(self) -> float:
        """The weight of the curve's smallest error."""
        return best_weight(CURVE_WEIGHTS, self.curve)


@cache
def trained_weights(case: str) -> TrainedWeights:
    """Search the weights for a case."""
    recordings = [simulate_samples(case_named(case), root) for root in training_roots()]

    def rmse(weight: float) -> float:
        return float(rms(np.array([weight_rmse_deg(case, of, weight) for of in recordings])))

    return TrainedWeights(
        search_weight(rmse),
        search_weight(lambda convex: rmse(weight_of_sum(convex))),
        np.array(
            [weight_curve(lambda w, of=of: weight_rmse_deg(case, of, w)) for of in recordings]  # type: ignore[misc]
        ),
    )


def training_roots() -> list[np.random.SeedSequence]:
    """Return the root of every training recording."""
    return [
        np.random.SeedSequence(TRAINING.entropy, spawn_key=(*TRAINING.spawn_key, number))
        for number in range(RECORDINGS)
    ]


def rms(errors: Array) -> Array:
    """Return the root mean square over the first axis."""
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=0)))


def weight_rmse_deg(case: str, samples: TiltSamples, weight: float) -> float:
    """Return the RMS of the error by which weights are chosen in a case."""
    direction, _ = run_compiled(weight, samples.time_s, samples.acceleration_g, samples.rates)
    return float(rms(ERRORS[case_named(case).weighed_by](samples, direction)))


def fused(samples: TiltSamples, config: FixedWeightConfig) -> Array:
    """Return the direction (n, 3) that the recursion finds."""
    return run(config, samples.time_s, samples.acceleration_g, samples.rates)
