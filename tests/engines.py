"""One estimator twice: in compiled C, and around the stage that CasADi interprets."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import pytest

from estimation import native
from estimation.engine import CompiledEngine
from estimation.estimate import Estimate
from estimation.estimator import Estimator
from estimation.recording import Measurement

EstimatorT = TypeVar("EstimatorT", bound=Any)

needs_compiler = pytest.mark.skipif(
    shutil.which("gcc") is None and shutil.which("cc") is None, reason="no C compiler"
)


def compiled_and_interpreted(
    build: Callable[[], EstimatorT],
) -> tuple[EstimatorT, EstimatorT]:
    """Build an estimator with and without a compiler."""
    compiled = build()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "compiler", lambda: None)
        interpreted = build()
    assert isinstance(_engine(compiled), CompiledEngine)
    assert not isinstance(_engine(interpreted), CompiledEngine)
    return compiled, interpreted


def _engine(estimator: Any) -> Any:
    """Return what makes its steps."""
    return estimator.engine


def steps(estimator: Estimator[Any], measurements: Sequence[Measurement]) -> list[Estimate]:
    """Return the estimates of all steps."""
    state, estimates = estimator.init(), []
    for measurement in measurements:
        state, estimate = estimator.step(state, measurement)
        estimates.append(estimate)
    return estimates
