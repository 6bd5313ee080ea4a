"""The paper of a pen file: what it demands of the tip, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from mhe import constraint_rows
from models.errors import InputError
from models.paper import Paper
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen, parse_pen
from models.state_space import StateSpaceModel
from tests.models.pens import ACCELEROMETER, CAMERA, call
from tests.references.free_states import still_state

SENSORS: dict[str, Any] = {
    "accel": {"kind": "accelerometer", **ACCELEROMETER},
    "camera": {"kind": "pose_camera", **CAMERA},
    "tip": {"kind": "contact", "height_mm": 20.05, "std_mm": 0.5},
}
TEXT = """
name = "p"
[paper]
height_cm = 2.0
touch_tolerance_mm = 0.1
[sensors.accel]
kind = "accelerometer"
noise_density_ug_per_sqrt_hz = 90
bandwidth_hz = 50
[sensors.tip]
kind = "contact"
height_mm = 20.05
std_mm = 0.5
"""


def pen(**others: Any) -> PenConfig:
    return parse_pen({"name": "p", "sensors": SENSORS, **others})


def model(*sensors: str, **paper: float) -> StateSpaceModel:
    return pen_model(pen(paper=paper), sensors)


def test_a_pen_has_no_paper_unless_it_says_so(tmp_path: Path) -> None:
    assert pen().paper is None
    assert np.isinf(pen_model(pen()).lower).all()
    path = tmp_path / "pen.toml"
    path.write_text(TEXT, "utf-8")
    paper = load_pen(path).paper
    assert paper is not None
    assert (paper.height_m, paper.touch_tolerance_m) == pytest.approx((0.02, 1e-4), rel=1e-14)


def test_an_empty_table_is_paper_at_height_zero() -> None:
    sensors = {"camera": SENSORS["camera"]}
    assert pen(paper={}, sensors=sensors).paper == Paper(height_m=0.0, touch_tolerance_m=None)


def test_the_tip_is_never_below_the_paper() -> None:
    held = model("accel", "camera", height_m=0.02)
    assert constraint_rows.count(held) == 1
    assert held.lower[2] == 0.02
    assert np.isinf(np.delete(held.lower, 2)).all()
    assert np.isinf(held.upper).all()
    assert held.inequality.numel_out(0) == 0


def test_a_touching_tip_is_on_the_paper() -> None:
    held = model("accel", "camera", "tip", height_m=0.02, touch_tolerance_mm=0.1)
    assert held.lower[2] == 0.02
    x = np.linspace(1, 2, held.n_x)
    x[2] = 0.0203
    assert call(held.inequality, x) == pytest.approx([0.0002], rel=1e-12)
    assert held.conditions is not None
    names = np.array(held.reading_names)
    assert names[held.conditions[0]].tolist() == ["tip_z"]
    touching, in_the_air = held.stack({"tip": np.array([0.02])}), held.stack({})
    assert constraint_rows.demanded(held, touching).tolist() == [True, True]
    assert constraint_rows.demanded(held, in_the_air).tolist() == [True, False]


def test_without_a_contact_sensor_nothing_says_that_the_tip_touches() -> None:
    held = model("accel", "camera", height_m=0.02, touch_tolerance_mm=0.1)
    assert held.lower[2] == 0.02
    assert held.inequality.numel_out(0) == 0


def test_every_contact_sensor_says_that_the_tip_touches() -> None:
    second = {**SENSORS, "switch": {"kind": "contact", "height_mm": 20.0, "std_mm": 1.0}}
    paper = {"height_m": 0.02, "touch_tolerance_mm": 0.1}
    held = pen_model(pen(paper=paper, sensors=second), ("switch", "accel", "tip"))
    assert held.conditions is not None
    names = np.array(held.reading_names)
    assert [names[row].tolist() for row in held.conditions] == [["switch_z"], ["tip_z"]]


def test_bounds_above_the_paper_stay() -> None:
    bounds = {"tip_z_m": (-np.inf, 0.3), "elevation_rad": (0.1, 1.4)}
    held = pen_model(pen(paper={"height_m": 0.02}, bounds=bounds))
    assert (held.lower[2], held.upper[2]) == (0.02, 0.3)
    x = np.zeros(held.n_x)
    x[:18] = still_state(1.5)
    assert call(held.inequality, x) == pytest.approx([0.1, -1.4], abs=1e-12)


def test_bounds_above_the_paper_stay_without_spin() -> None:
    bounds = {"tip_z_m": (-np.inf, 0.3), "elevation_rad": (0.1, 1.4)}
    held = pen_model(pen(paper={"height_m": 0.02}, bounds=bounds, degrees_of_freedom=5))
    assert (held.lower[2], held.upper[2], held.upper[4]) == (0.02, 0.3, 1.4)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "a second lower bound": (
        {"bounds": {"tip_z_m": (0.0, np.inf)}},
        "its height_m 0.02 and the lower bound 0 on tip_z_m say the same thing, expected one of "
        "them",
    ),
    "no room": (
        {"bounds": {"tip_z_m": (-np.inf, 0.02)}},
        "its height_m 0.02 is not below the upper bound 0.02 on tip_z_m, expected room",
    ),
    "a contact below": (
        {"sensors": {**SENSORS, "tip": {"kind": "contact", "height_mm": 19.0, "std_mm": 1.0}}},
        "contact sensor tip touches a plane at height_m 0.019, expected 0.02 to 0.0201",
    ),
    "a contact above": (
        {"sensors": {**SENSORS, "tip": {"kind": "contact", "height_mm": 20.2, "std_mm": 1.0}}},
        "contact sensor tip touches a plane at height_m 0.0202, expected 0.02 to 0.0201",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_contradicts_the_paper_is_refused(name: str) -> None:
    others, sentence = REFUSED[name]
    paper = {"height_m": 0.02, "touch_tolerance_mm": 0.1}
    with pytest.raises(InputError) as error:
        pen(**{"paper": paper, **others})
    assert str(error.value).startswith(f"pen: key paper: {sentence}")


def test_a_contact_anywhere_above_is_fine_without_a_tolerance() -> None:
    assert pen(paper={"height_m": -1.0}).paper is not None


@pytest.mark.parametrize(
    ("paper", "sentence"),
    [
        ({"touch_tolerance_mm": 0.0}, "key paper.touch_tolerance_m: Input should be greater than"),
        (
            {"touch_tolerance": 1.0},
            "unknown key touch_tolerance; expected one of height_m, slope, ",
        ),
        ({"height_inch": 1.0}, "unknown key height_inch; expected height_m or height_cm or heig"),
        ({"height_m": np.inf}, "key paper.height_m: Input should be a finite number"),
    ],
    ids=["no tolerance", "no unit", "unknown unit", "infinite"],
)
def test_bad_values_name_their_key(paper: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=r"^pen: key paper") as error:
        pen(paper=paper)
    assert sentence in str(error.value)


def test_paper_is_frozen() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Paper().height_m = 1.0  # type: ignore[misc]
