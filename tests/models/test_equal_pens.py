"""Pens that say the same share one model; pens that differ in anything never do."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from pydantic import BaseModel

from models.bundled import bundled_pens
from models.content import ByContent
from models.errors import InputError
from models.motion import Motion
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.reading import MovingBody, SymbolicReading
from tests.contracts import arrays_within

SENSORS = ("accel", "gyro")


def other(value: Any) -> Any:
    """Return the nearest value that is not the given one."""
    match value:
        case bool():
            return not value
        case int():
            return value + 1
        case float():
            return np.nextafter(value, np.inf).item()
        case str():
            return value + "'"
        case None:
            return 1.0
    raise TypeError(type(value))


def changed(value: Any) -> Iterator[tuple[str, Any]]:
    """Go through copies of a value that differ from it in one leaf, each with where that is."""
    if isinstance(value, BaseModel):
        for key, item in value:
            for where, copy in changed(item):
                yield f"{key}.{where}", value.model_copy(update={key: copy})
    elif isinstance(value, Mapping):
        for key, item in value.items():
            for where, copy in changed(item):
                yield f"{key}.{where}", {**value, key: copy}
    elif isinstance(value, tuple):
        for i, item in enumerate(value):
            for where, copy in changed(item):
                yield f"{i}.{where}", (*value[:i], copy, *value[i + 1 :])
    else:
        yield "", other(value)


def test_a_pen_is_found_by_what_it_says(tmp_path: Path) -> None:
    file = shutil.copy(bundled_pens()["reference"], tmp_path / "another.toml")
    model = pen_model("reference", SENSORS)
    assert pen_model(load_pen("reference"), list(SENSORS)) is model
    assert pen_model(file, iter(SENSORS)) is model
    assert pen_model(load_pen("reference").model_copy(deep=True), SENSORS) is model


@pytest.mark.parametrize("pen", bundled_pens())
def test_whatever_is_changed_it_is_another(pen: str) -> None:
    config = load_pen(pen)
    copies = dict(changed(config))
    assert len(copies) > 50
    assert {key.split(".")[0] for key in copies} >= set(PenConfig.model_fields) - {
        "bounds", "printed_errors"
    }  # fmt: skip
    for where, copy in copies.items():
        assert ByContent(copy) != ByContent(config), where
    assert len({ByContent(copy) for copy in copies.values()}) == len(copies)


def test_bounds_and_errors_count() -> None:
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": 5})
    bounded, wider = (
        pen.model_copy(update={"bounds": {"tip_z_m": (low, np.inf)}}) for low in (0.0, -1.0)
    )
    assert pen_model(bounded, SENSORS).lower[2] == 0.0
    assert pen_model(wider, SENSORS).lower[2] == -1.0
    assert pen_model(pen, SENSORS).lower[2] == -np.inf
    wrong = pen.model_copy(update={"printed_errors": ("E2",)})
    assert pen_model(wrong, SENSORS) is not pen_model(pen, SENSORS)


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ({"fixed_spin_rad": 0.0}, {"fixed_spin_rad": -0.0}),
        ({"reach_m": 1.0}, {"reach_m": 1}),
        ({"reach_m": 1.0}, {"reach_m": np.float64(1.0)}),
        ({"bounds": {"a": 0.0, "b": 0.0}}, {"bounds": {"b": 0.0, "a": 0.0}}),
        ({"bounds": {"a": -np.inf}}, {"bounds": {"a": np.nan}}),
        ({"paper": None}, {"paper": ()}),
    ],
)  # fmt: skip
def test_what_python_or_a_file_takes_for_equal_is_not(
    one: dict[str, Any], two: dict[str, Any]
) -> None:
    pen = load_pen("reference")
    assert ByContent(pen.model_copy(update=one)) == ByContent(pen.model_copy(update=one))
    assert ByContent(pen.model_copy(update=one)) != ByContent(pen.model_copy(update=two))


def test_sensors_and_options_count() -> None:
    pen = load_pen("reference")
    turned = pen.model_copy(update={"sensors": dict(reversed(pen.sensors.items()))})
    names = [sensor.name for sensor in pen_model(pen).sensors]
    assert [sensor.name for sensor in pen_model(turned).sensors] == names[::-1]
    assert pen_model(pen, SENSORS) is not pen_model(pen, SENSORS[::-1])
    alone = pen_model(pen, SENSORS, writing_area=False, rest=False)
    assert [sensor.name for sensor in alone.sensors] == list(SENSORS)
    assert len(pen_model(pen, SENSORS, rest=False).sensors) > len(alone.sensors)


def test_a_pen_that_is_changed_in_place_gives_another_model() -> None:
    pen = load_pen("reference").model_copy(deep=True)
    before, accel = pen_model(pen, SENSORS), pen.sensors["accel"]
    assert isinstance(accel, Accelerometer)
    worse = accel.model_copy(update={"noise_density_m_s2_per_sqrt_hz": 1.0})
    pen.sensors["accel"] = worse  # type: ignore[index]
    after = pen_model(pen, SENSORS)
    assert after.noise_std[0] > before.noise_std[0]
    pen.sensors["accel"] = accel  # type: ignore[index]
    assert pen_model(pen, SENSORS) is before


def test_a_file_that_is_written_anew_is_read_anew(tmp_path: Path) -> None:
    file, text = tmp_path / "pen.toml", bundled_pens()["reference"].read_text("utf-8")
    file.write_text(text, "utf-8")
    before = pen_model(file, SENSORS)
    file.write_text(text.replace("name = ", 'name = "new" #', 1), "utf-8")
    assert pen_model(file, SENSORS).name != before.name


class OwnMotion:
    """Somebody's own motion, which is no configuration: the pen's, with another speed."""

    def __init__(self, motion: Motion, speed_m_s: float) -> None:
        self.attitude, self.tip = motion.attitude, motion.tip
        self.faster(speed_m_s)

    def faster(self, speed_m_s: float) -> None:
        self.tip = self.tip.model_copy(update={"speed_m_s": speed_m_s})


def velocity_std(pen: PenConfig) -> float:
    model = pen_model(pen, SENSORS)
    x, w = model.prior.mean, np.ones(model.n_w)
    moved = np.asarray(model.f(x, w, 0.1)).ravel() - np.asarray(model.f(x, 0 * w, 0.1)).ravel()
    return float(np.abs(moved).max())


def test_an_object_of_ones_own_is_never_taken_for_another() -> None:
    pen = load_pen("reference")
    one, two = (OwnMotion(pen.motion, speed) for speed in (0.1, 100.0))
    moving = [pen.model_copy(update={"motion": own}) for own in (one, two)]
    slow, fast = (velocity_std(own) for own in moving)
    assert slow < fast
    one.faster(100.0)
    assert velocity_std(moving[0]) == fast


class Upside(Accelerometer):
    """An accelerometer of somebody's own that says the same and reads the opposite."""

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        reading = super().symbolic_reading(body, bias)
        return SymbolicReading(-reading.h, reading.noise_std)


def test_a_sensor_of_ones_own_class_is_not_the_one_it_is_made_of() -> None:
    pen = load_pen("reference")
    said = vars(pen.sensors["accel"])
    own = pen.model_copy(
        update={"sensors": {**pen.sensors, "accel": Upside.model_construct(**said)}}
    )
    plain, upside = pen_model(pen, ("accel",)), pen_model(own, ("accel",))
    x = plain.prior.mean
    down, up = (np.asarray(model.sensor("accel").h(x)) for model in (plain, upside))
    np.testing.assert_array_equal(up, -down)
    assert pen_model(own, ("accel",)) is upside


def test_nobody_writes_into_a_model() -> None:
    model = pen_model("reference")
    made = [model.noise_std, model.row_needs, model.saturation, model.measured_rows]
    arrays = [*arrays_within(model), *made, model.inequality_needs, model.sensors[0].row_needs]
    assert len(arrays) > 10
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert model.bounded(tip_z_m=(0.0, 1.0)).lower[2] == 0.0
    assert pen_model("reference").lower[2] == -np.inf


def test_what_is_wrong_is_said_each_time() -> None:
    for _ in range(2):
        with pytest.raises(InputError, match="sensor acel is not in the pen"):
            pen_model("reference", ("acel",))
