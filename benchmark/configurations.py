"""Choices of sensors that benchmark and contract tests share.

A sensor configuration exists for both once it has a row here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from benchmark.bodies import PAPER_MOTION
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from pen_mhe.estimators import ESTIMATORS

BENCHMARK_ESTIMATORS = tuple(name for name, row in ESTIMATORS.items() if row.in_benchmark)
"""The estimators of the benchmark; ``mhe`` ends in ``mhe-ipopt``'s optimum (suite `optimum`)."""


@dataclass(frozen=True)
class SensorConfiguration:
    """A choice of sensors of the reference pen, or of the turntable.

    Parameters
    ----------
    label : for tables
    sensors : names in its file; a pen's writing area stands in where no camera is
    needs_camera : it wants a camera beside the pen
    """

    label: str
    sensors: tuple[str, ...]
    needs_camera: bool = False


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
        "camera": SensorConfiguration("camera", ("camera",), needs_camera=True),
        "two accelerometers+camera": SensorConfiguration(
            "two accelerometers with camera",
            ("accel_lower", "accel_upper", "camera"),
            needs_camera=True,
        ),
        "accel+gyro+camera": SensorConfiguration(
            "both with camera", ("accel", "gyro", "camera"), needs_camera=True
        ),
    }
)
"""Sensor configurations of the benchmark, from cheap to dear; every estimator must work on each."""


TURNTABLE_CONFIGURATIONS: Mapping[str, SensorConfiguration] = MappingProxyType(
    {
        "accel": SensorConfiguration("accelerometer", ("accel",)),
        "gyro": SensorConfiguration("gyroscope", ("gyro",)),
        "accel+gyro": SensorConfiguration("both", ("accel", "gyro")),
    }
)
"""The turntable's observation models: equations (10), (11) and (12) of [Pen]."""


def contract_models() -> Mapping[str, StateSpaceModel]:
    """Return every model × configuration that estimators must work on, by name."""
    models = {}
    for dof in (5, 6):
        change: dict[str, object] = {"degrees_of_freedom": dof}
        pen = load_pen("reference").model_copy(
            update=change | ({"motion": PAPER_MOTION} if dof == 5 else {})
        )
        for name, configuration in CONFIGURATIONS.items():
            models[f"pen{dof} {name}"] = pen_model(pen, configuration.sensors)
    for name, configuration in TURNTABLE_CONFIGURATIONS.items():
        models[f"turntable {name}"] = turntable_model(paper_turntable(), configuration.sensors)
    return MappingProxyType(models)
