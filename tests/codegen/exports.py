"""Exports of estimators for tests, and the same estimators interpreted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from codegen.export import Export, export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from ekf_baseline.ekf import Ekf
from estimation import native
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import Estimator
from estimation.recording import Measurement
from estimation.result import ResultReader
from mhe.realtime import MheRti
from models.state_space import StateSpaceModel
from tests.configs import config_for
from tests.engines import steps

Settings = Mapping[str, Any]
KINDS: dict[str, Any] = {"ekf": Ekf, "mhe-rti": MheRti}
SHORT: dict[str, Settings] = {"ekf": {}, "mhe-rti": {"horizon": 4}}
"""Estimator → settings for quick tests."""

FORMS = (("double", "covariance"), ("double", "root"), ("float", "root"))


def made(
    name: str,
    model: StateSpaceModel,
    real: str = "double",
    form: str | None = None,
    settings: Settings | None = None,
) -> Export:
    """Write an export, with the short settings unless others are given."""
    return export_texts(exportable(name, model, **(settings or SHORT[name])), real, form=form)


def exported(
    name: str,
    model: StateSpaceModel,
    real: str = "double",
    form: str | None = None,
    settings: Settings | None = None,
) -> Exported:
    """Compile an export, with the short settings unless others are given."""
    return Exported(made(name, model, real, form, settings))


def interpreted(
    name: str, model: StateSpaceModel, settings: Settings | None = None
) -> Estimator[Any]:
    """Build the estimator around CasADi's virtual machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "compiler", lambda: None)
        found: Estimator[Any] = KINDS[name](model, config_for(name, **(settings or SHORT[name])))
    return found


def told(estimator: Estimator[Any], measurements: Sequence[Measurement]) -> list[Estimate]:
    """Return the estimates of all steps, without windows, which an export does not tell."""
    return [replace(estimate, window=None) for estimate in steps(estimator, measurements)]


def history(estimator: Exported, measurements: Iterable[Measurement]) -> EstimateHistory:
    """Return all that an export tells, from its own structure, as a history."""
    estimator.init()
    rows = []
    for measurement in measurements:
        estimator.take(measurement.time_s, measurement.y)
        rows.append(estimator.told())
    reader = ResultReader(estimator.model, estimator.exported.loop.lags)
    return reader.history(estimator.name, np.array(rows), covariances=True)
