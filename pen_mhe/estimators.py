"""The tables that benchmark, command line and contract tests share.

An estimator or a sensor configuration exists for all of them once it has a row here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.estimator import Estimator
from mhe.config import MheConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.errors import InputError
from models.state_space import StateSpaceModel

SPARSE_NOISE = 1.0
"""Threshold of Huber's loss of ``mhe-sparse``: noise within its standard deviation is Gaussian."""


@dataclass(frozen=True)
class EstimatorSettings:
    """Settings of every estimator; each reads its own.

    Parameters
    ----------
    ekf : settings of ``ekf``
    mhe : settings of ``mhe-ipopt``, ``mhe-rti``, ``mhe`` and (but for its loss) ``mhe-sparse``
    """

    ekf: EkfConfig = field(default_factory=EkfConfig)
    mhe: MheConfig = field(default_factory=MheConfig)

    @property
    def sparse(self) -> MheConfig:
        """Settings of ``mhe-sparse``: as of ``mhe``, with Huber's loss on the process noise."""
        if self.mhe.sparse_noise is not None:
            return self.mhe
        return replace(self.mhe, sparse_noise=SPARSE_NOISE)


ESTIMATORS: Mapping[str, Callable[[StateSpaceModel, EstimatorSettings], Estimator[Any]]] = (
    MappingProxyType(
        {
            "ekf": lambda model, settings: Ekf(model, settings.ekf),
            "mhe-ipopt": lambda model, settings: MheIpopt(model, settings.mhe),
            "mhe-rti": lambda model, settings: MheRti(model, settings.mhe),
            "mhe": lambda model, settings: Mhe(model, settings.mhe),
            "mhe-sparse": lambda model, settings: Mhe(model, settings.sparse),
        }
    )
)
"""Estimator name → constructor."""

LEAST_SQUARES = tuple(name for name in ESTIMATORS if name != "mhe-sparse")
"""The estimators that weigh everything by least squares: on a linear model all are one."""


DEFAULT_ESTIMATOR = "mhe"


def check_estimator(name: str) -> None:
    """Raise `InputError` unless an estimator has this name."""
    if name not in ESTIMATORS:
        raise InputError(f"estimator {name} is unknown, expected one of {', '.join(ESTIMATORS)}")


def create_estimator(
    name: str, model: StateSpaceModel, settings: EstimatorSettings | None = None
) -> Estimator[Any]:
    """Build an estimator by name; raises `InputError` for an unknown one."""
    check_estimator(name)
    return ESTIMATORS[name](model, settings or EstimatorSettings())
