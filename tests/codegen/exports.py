"""Exports of estimators for tests, and the same estimators interpreted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from codegen.export import Export, export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from ekf_baseline.ekf import Ekf, EkfConfig
from estimation import native
from estimation.estimate import Estimate
from estimation.estimator import Estimator
from estimation.recording import Measurement
from mhe.config import MheConfig
from mhe.realtime import MheRti
from models.state_space import StateSpaceModel
from tests.engines import steps

Config = EkfConfig | MheConfig | None
KINDS: dict[str, Any] = {"ekf": Ekf, "mhe-rti": MheRti}
SHORT: dict[str, Config] = {"ekf": None, "mhe-rti": MheConfig(horizon=4)}
"""Estimator → settings for quick tests."""

FORMS = (("double", "covariance"), ("double", "root"), ("float", "root"))


def made(
    name: str,
    model: StateSpaceModel,
    real: str = "double",
    form: str | None = None,
    config: Config = None,
) -> Export:
    """Write an export, with the short settings unless others are given."""
    return export_texts(exportable(name, model, config or SHORT[name]), real, form)


def exported(
    name: str,
    model: StateSpaceModel,
    real: str = "double",
    form: str | None = None,
    config: Config = None,
) -> Exported:
    """Compile an export, with the short settings unless others are given."""
    return Exported(made(name, model, real, form, config))


def interpreted(name: str, model: StateSpaceModel, config: Config = None) -> Estimator[Any]:
    """Build the estimator around CasADi's virtual machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "compiler", lambda: None)
        found: Estimator[Any] = KINDS[name](model, config or SHORT[name])
    return found


def told(estimator: Estimator[Any], measurements: Sequence[Measurement]) -> list[Estimate]:
    """Return the estimates of all steps, without windows, which an export does not tell."""
    return [replace(estimate, window=None) for estimate in steps(estimator, measurements)]
