"""Causality of exported C: what arrives after an instant changes no estimate before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from codegen.exported import Exported
from estimation.estimate import EstimateHistory
from estimation.recording import Recording
from tests.codegen.exports import exported, history
from tests.engines import needs_compiler
from tests.estimation.test_causality import (
    LONG_S,
    QUICK_S,
    SETTINGS,
    check,
    model,
    model_with_area,
)

pytestmark = needs_compiler


def by_its_functions(estimator: Exported, recording: Recording) -> EstimateHistory:
    """Run an export over a recording as it arrived, by one call of its step after another."""
    measurements = list(recording.measurements(estimator.model, causal=True))
    arrivals = np.array([m.arrival_s for m in measurements], dtype=float)
    return replace(history(estimator, measurements), arrival_s=arrivals)


@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_what_arrives_later_changes_no_estimate(name: str) -> None:
    estimator = exported(name, model(), settings=SETTINGS[name])
    check(estimator, QUICK_S, cuts=2, driver=by_its_functions)


@pytest.mark.slow
@pytest.mark.parametrize(("real", "form"), [("double", "covariance"), ("float", "root")])
@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_nor_in_a_longer_recording(name: str, real: str, form: str) -> None:
    """With a writing area, whose readings the step adds by itself."""
    estimator = exported(name, model_with_area(), real, form, SETTINGS[name])
    check(estimator, LONG_S, cuts=6, driver=by_its_functions)
