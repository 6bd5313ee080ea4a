"""A contact whose plane slopes: as a reading, simulated, and as a constraint."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from estimation.recording import Measurement
from mhe import constraint_rows
from models.errors import InputError
from models.noisy_readings import touching
from models.paper import Paper
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import parse_pen
from models.sensor_kinds.contact import Contact
from tests.mhe.runs import reference_window
from tests.models.pens import ACCELEROMETER, CAMERA, call, pen, random_state

SLOPE = (0.1, -0.05)
HEIGHT_M = 0.02
SENSORS: dict[str, Any] = {
    "accel": {"kind": "accelerometer", **ACCELEROMETER},
    "camera": {"kind": "pose_camera", **CAMERA, "position_std_m": 1e-3},
    "tip": {"kind": "contact", "std_m": 1e-2, "height_m": HEIGHT_M, "slope": SLOPE},
}


def plane_z(x: Any, y: Any) -> Any:
    return HEIGHT_M + SLOPE[0] * x + SLOPE[1] * y


@pytest.mark.parametrize("degrees_of_freedom", [5, 6])
def test_it_reads_how_far_the_tip_is_from_the_plane(degrees_of_freedom: int) -> None:
    sensors = {"tip": Contact(std_m=5e-4, height_m=HEIGHT_M, slope=SLOPE)}
    model = pen_model(pen(degrees_of_freedom, sensors), writing_area=False)
    x = random_state(np.random.default_rng(0), degrees_of_freedom)
    away = x[2] - plane_z(x[0], x[1])
    assert call(model.sensor("tip").residual, HEIGHT_M, x) == pytest.approx([-away], abs=1e-15)


def test_a_plane_without_slope_is_the_tips_height_to_the_bit() -> None:
    x = random_state(np.random.default_rng(0), 6)
    h = [
        pen_model(pen(6, {"tip": Contact(std_m=5e-4, **more)}), writing_area=False).sensor("tip").h
        for more in ({}, {"slope": (0.0, 0.0)})
    ]
    assert str(h[0]) == str(h[1])
    assert call(h[0], x)[0] == x[2]


def test_the_simulated_tip_touches_the_plane_where_it_is() -> None:
    sensors = {"tip": Contact(std_m=5e-4, height_m=HEIGHT_M, slope=SLOPE)}
    model = pen_model(pen(6, sensors), writing_area=False)
    states = np.zeros((4, model.n_x))
    states[:, 0], states[:, 1] = [0.0, 0.1, 0.1, -0.2], [0.0, 0.1, 0.1, 0.3]
    away = np.array([0.0, 9e-4, 1.1e-3, -9e-4])
    states[:, 2] = plane_z(states[:, 0], states[:, 1]) + away
    read = touching(model.sensor("tip"), states)[:, 0]
    np.testing.assert_array_equal(read, [HEIGHT_M, HEIGHT_M, np.nan, HEIGHT_M])


def sloping(paper: Paper | None, **changed: Any) -> PenConfig:
    config = pen(6, {**SENSORS, **changed})
    return config.model_copy(update={"paper": paper})


def test_a_tip_is_held_to_a_paper_that_slopes() -> None:
    """Above it always, within a tenth of a millimetre of it while the contact reads."""
    free = pen_model(sloping(None))
    held = pen_model(sloping(Paper(height_m=HEIGHT_M, touch_tolerance_m=1e-4)))
    assert np.isinf(held.lower).all()
    assert constraint_rows.count(held) == 2
    touching_, in_the_air = held.stack({"tip": np.array([HEIGHT_M])}), held.stack({})
    assert constraint_rows.demanded(held, touching_).tolist() == [True, True]
    assert constraint_rows.demanded(held, in_the_air).tolist() == [True, False]

    rng = np.random.default_rng(0)
    away = np.array([-2, -1, 1, 3, 5, 4, 2, 1, 0, -2]) * 1e-3
    touches = np.array([1, 1, 1, 0, 0, 0, 1, 1, 1, 1], dtype=bool)
    x = np.linspace(0.0, 0.05, len(away))
    measurements = []
    for k, over in enumerate(away):
        pose = np.array([x[k], 0, plane_z(x[k], 0) + over, 0, 0, 0])
        pose[3:] = np.asarray(held.sensor("camera").h(held.prior.mean))[3:, 0]
        pose[:3] += 1e-4 * rng.standard_normal(3)
        force = np.asarray(held.sensor("accel").h(held.prior.mean)).ravel()
        readings = {"camera": pose, "accel": force}
        if touches[k]:
            readings["tip"] = np.array([HEIGHT_M])
        measurements.append(Measurement(0.05 * k, held.stack(readings)))
    heights = []
    for model in (free, held):
        found = reference_window(model, measurements)
        assert found.status.is_solved
        tips = np.array(found.trajectory.states)[:, :3]
        heights.append(tips[:, 2] - plane_z(tips[:, 0], tips[:, 1]))
    unheld, kept = heights
    assert (kept > -1e-9).all()
    assert (kept[touches] < 1e-4 + 1e-9).all()
    assert kept[~touches].max() > 1e-3
    assert unheld.min() < -5e-4
    assert unheld[touches].max() > 5e-4


def test_a_paper_takes_the_slope_of_the_contact_or_says_the_same() -> None:
    data = {"name": "p", "sensors": SENSORS}
    same = {"height_m": HEIGHT_M, "slope": SLOPE}
    x = random_state(np.random.default_rng(1), 6)
    rows = []
    for paper in ({"height_m": HEIGHT_M}, same):
        model = pen_model(parse_pen({**data, "paper": paper}), ["camera"])
        rows.append(call(model.inequality, x))
    np.testing.assert_array_equal(*rows)
    assert rows[0] == pytest.approx([plane_z(x[0], x[1]) - x[2]], abs=1e-15)
    with pytest.raises(
        InputError, match=r"slope \[0.1, -0.05\], expected that of the paper: \[0.0"
    ):
        parse_pen({**data, "paper": {**same, "slope": [0.0, 0.0]}})
