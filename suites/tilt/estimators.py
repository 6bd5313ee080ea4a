"""The estimators of the suite as data, and one run of each kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.tasks.task import Quantity
from classical_baseline.fixed_weight import FixedWeightConfig, weight_of_sum
from classical_baseline.weight_search import Ended, WeightSearch
from estimation.estimator import Estimator, run
from models.arrays import Array
from models.priors import replaced_prior
from models.state_space import StateSpaceModel
from models.turntable import turntable_model
from pen_mhe.estimators import create_estimator
from suites.tilt.cases import FULL_TURN, Installation
from suites.tilt.operations import operations, operations_of_step, uncounted
from suites.tilt.recursion import raw_function, recursion_function, run_compiled, run_raw_compiled
from suites.tilt.samples import SENSORS, TiltSamples, case_named, installed
from suites.tilt.turns import gravity_direction, tilts_of
from suites.tilt.weights import fused, trained_weights

ACCELEROMETER, CURVE = "accelerometer", "fixed-weight-curve"
PUBLISHED = FixedWeightConfig()
"""w = 0.25."""

FIXED_WEIGHT: Mapping[str, Callable[[str], FixedWeightConfig]] = MappingProxyType(
    {
        "fixed-weight": lambda case: PUBLISHED,
        "fixed-weight-searched": lambda case: FixedWeightConfig(
            trained_weights(case).searched.weight
        ),
        "fixed-weight-best": lambda case: FixedWeightConfig(trained_weights(case).best),
        "fixed-weight-carried": lambda case: FixedWeightConfig(trained_weights(FULL_TURN).best),
        "fixed-weight-previous": lambda case: FixedWeightConfig(
            trained_weights(case).best, form="tangents", sign="previous"
        ),
        "fixed-weight-convex": lambda case: FixedWeightConfig(weight_of_sum(PUBLISHED.weight)),
        "fixed-weight-convex-searched": lambda case: FixedWeightConfig(
            weight_of_sum(trained_weights(case).searched_convex.weight)
        ),
    }
)
"""Estimator → its settings in a case: published, found by the published search, best up to
300, best in the full turn, best but with tangents and the sign of the previous z; published and
searched where w is read as that of (1 - w) R_acc + w R_g."""

MODEL_BASED = tuple(reversed(BENCHMARK_ESTIMATORS))
"""Estimators with a model, the slow ones first."""

START_STD_RAD = float(np.radians(2.0))
"""Of the start that a model is told: the angles of the first reading, as in (10)."""


@dataclass(frozen=True, eq=False)
class TiltRun:
    """What an estimator says of samples.

    Parameters
    ----------
    model : its name; empty without one
    direction : (n, 3)
    roll_std_deg : (n,) as claimed; None without a claim
    step_time_s : (m,) per sample
    figures : of its own
    solved_fraction : of the steps
    """

    model: str
    direction: Array
    roll_std_deg: Array | None
    step_time_s: Array
    figures: tuple[Quantity, ...]
    solved_fraction: float = 1.0


def run_accelerometer(samples: TiltSamples) -> TiltRun:
    """Take every reading as it is."""
    direction, seconds = run_raw_compiled(samples.acceleration_g)
    return TiltRun("", direction, None, seconds, (_operations(operations(raw_function())),))


def run_fixed_weight(estimator: str, case: str, samples: TiltSamples) -> TiltRun:
    """Run the recursion with one of `FIXED_WEIGHT`; its time is that of the default form."""
    config = FIXED_WEIGHT[estimator](case)
    _, seconds = run_compiled(config.weight, samples.time_s, samples.acceleration_g, samples.rates)
    figures = (
        _operations(operations(recursion_function())),
        Quantity.single("weight", "1", config.weight),
        *(figure for figures in FIGURES_OF.get(estimator, ()) for figure in figures(case)),
    )
    return TiltRun("", fused(samples, config), None, seconds, figures)


def _search_ended(search: WeightSearch) -> tuple[Quantity, ...]:
    """Return how the published search for the weight ended."""
    ended = search.ended
    return tuple(
        Quantity.single(f"search ended, {name}", "1", float(ended is way))
        for name, way in (
            ("inside", Ended.INSIDE),
            ("lower bound", Ended.LOWER_BOUND),
            ("upper bound", Ended.UPPER_BOUND),
        )
    )


def _best_of_each(case: str) -> tuple[Quantity, ...]:
    """Return the smallest and the largest of the weights that single recordings have best."""
    each = trained_weights(case).best_of_each
    return (
        Quantity.single("weight, smallest of the recordings", "1", min(each)),
        Quantity.single("weight, largest of the recordings", "1", max(each)),
    )


FIGURES_OF: Mapping[str, tuple[Callable[[str], tuple[Quantity, ...]], ...]] = MappingProxyType(
    {
        "fixed-weight-searched": (lambda case: _search_ended(trained_weights(case).searched),),
        "fixed-weight-convex-searched": (
            lambda case: _search_ended(trained_weights(case).searched_convex),
            lambda case: (
                Quantity.single(
                    "weight, convex", "1", trained_weights(case).searched_convex.weight
                ),
            ),
        ),
        "fixed-weight-best": (_best_of_each,),
    }
)
"""Estimator → what gives more figures of its own in a case."""


def run_model(estimator: str, case: str, samples: TiltSamples) -> TiltRun:
    """Run an estimator with the carrier's model, told the angles of the first reading."""
    installation = case_named(case).installation
    chosen = _estimator(estimator, installation)
    model = chosen.model
    first = [float(angle[0]) for angle in tilts_of(samples.acceleration_g[:1])]
    told = replaced_prior(
        model, dict(zip(model.state_names[:2], first, strict=True)), START_STD_RAD
    )
    recording = samples.recording(installed(installation).gravity_m_s2)
    history = run(chosen, recording, prior=told)
    passes = float(np.mean(history.iterations))
    own = [Quantity.single("passes", "1", passes)]
    if not uncounted(estimator):
        own.insert(0, _operations(operations_of_step(estimator, model, passes)))
    return TiltRun(
        model.name,
        gravity_direction(history.mean[:, 0], history.mean[:, 1]),
        np.degrees(history.std[:, 1]),
        history.step_time_s,
        tuple(own),
        history.solved_fraction,
    )


@cache
def _estimator(name: str, installation: Installation) -> Estimator[Any]:
    return create_estimator(name, _model(installation))


@cache
def _model(installation: Installation) -> StateSpaceModel:
    """Return the model that the estimators of an installation share."""
    return turntable_model(installed(installation), SENSORS)


def _operations(count: float) -> Quantity:
    return Quantity.single("operations", "1", float(count))
