"""The tables that benchmark, command line and contract tests share.

An estimator or a sensor configuration exists for all of them once it has a row here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.estimator import Estimator
from mhe.config import MheConfig
from mhe.ipopt import MheIpopt
from mhe.realtime import Mhe, MheRti
from models.errors import InputError
from models.pen import PenConfig, pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model

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

BENCHMARK_ESTIMATORS = tuple(name for name in LEAST_SQUARES if name != "mhe-ipopt")
"""The estimators of the benchmark; ``mhe`` ends in ``mhe-ipopt``'s optimum (`pen-mhe optimum`)."""

DEFAULT_ESTIMATOR = "mhe"


@dataclass(frozen=True)
class SensorConfiguration:
    """A choice of sensors of the reference pen, or of the turntable.

    Parameters
    ----------
    label : for tables
    sensors : names in its file; a pen's writing area stands in where no camera is
    """

    label: str
    sensors: tuple[str, ...]


CONFIGURATIONS: Mapping[str, SensorConfiguration] = MappingProxyType(
    {
        "accel": SensorConfiguration("accelerometer", ("accel",)),
        "gyro": SensorConfiguration("gyroscope", ("gyro",)),
        "accel+gyro": SensorConfiguration("both", ("accel", "gyro")),
        "two accelerometers": SensorConfiguration(
            "two accelerometers", ("accel_lower", "accel_upper")
        ),
        "accel+gyro+contact": SensorConfiguration(
            "both with contact", ("accel", "gyro", "contact")
        ),
        "camera": SensorConfiguration("camera", ("camera",)),
        "two accelerometers+camera": SensorConfiguration(
            "two accelerometers with camera", ("accel_lower", "accel_upper", "camera")
        ),
        "accel+gyro+camera": SensorConfiguration("both with camera", ("accel", "gyro", "camera")),
    }
)
"""Sensor configurations of the benchmark; every estimator must work on each."""

TURNTABLE_CONFIGURATIONS: Mapping[str, SensorConfiguration] = MappingProxyType(
    {
        "accel": SensorConfiguration("accelerometer", ("accel",)),
        "gyro": SensorConfiguration("gyroscope", ("gyro",)),
        "accel+gyro": SensorConfiguration("both", ("accel", "gyro")),
    }
)
"""The turntable's observation models: equations (10), (11) and (12) of [Pen]."""


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


@cache
def bundled_pens() -> Mapping[str, Path]:
    """Return the pen files that come with the package, by name."""
    folder = Path(str(resources.files("models"))) / "pens"
    return MappingProxyType({path.stem: path for path in sorted(folder.glob("*.toml"))})


def find_pen(pen: str | Path) -> PenConfig:
    """Load a pen file, or a bundled pen by its name."""
    if str(pen) in bundled_pens() and not Path(pen).is_file():
        return load_pen(bundled_pens()[str(pen)])
    if not Path(pen).exists():
        raise InputError(
            f"pen file {pen} does not exist; expected a file, "
            f"or a bundled pen: {', '.join(bundled_pens())}"
        )
    return load_pen(pen)


def contract_models() -> Mapping[str, StateSpaceModel]:
    """Return every model × configuration that estimators must work on, by name."""
    models = {}
    for dof in (5, 6):
        pen = find_pen("reference").model_copy(update={"degrees_of_freedom": dof})
        for name, configuration in CONFIGURATIONS.items():
            models[f"pen{dof} {name}"] = pen_model(pen, configuration.sensors)
    for name, configuration in TURNTABLE_CONFIGURATIONS.items():
        models[f"turntable {name}"] = turntable_model(paper_turntable(), configuration.sensors)
    return MappingProxyType(models)
