"""A window's problem is written once for a model and its settings, and anew for others."""

from __future__ import annotations

from typing import Any

import pytest

from mhe.config import WindowConfig
from mhe.reference.window import WindowProblem
from models.turntable import turntable_model

SENSORS = ("accel", "gyro")


@pytest.mark.parametrize(
    "other",
    [{"horizon": 4}, {"huber": {"accel": 3.0}}, {"huber": {"gyro": 3.0}}, {"sparse_noise": 2.0}],
)
def test_other_settings_are_another_problem(other: dict[str, Any]) -> None:
    model, settings = turntable_model(sensors=SENSORS), {"horizon": 3}
    written = WindowProblem.build(model, WindowConfig(**settings))
    assert WindowProblem.build(model, WindowConfig(**settings)) is written
    assert WindowProblem.build(model, WindowConfig(**{**settings, **other})) is not written


def test_another_model_is_another_problem() -> None:
    model, config = turntable_model(sensors=SENSORS), WindowConfig(horizon=3)
    bounded = model.bounded(tilt_phi_rad=(0.0, 1.0))
    assert WindowProblem.build(bounded, config).model is bounded
    assert WindowProblem.build(model, config).model is model
