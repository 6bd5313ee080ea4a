"""A key's unit is part of its name: every spelling of a quantity means the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from models.motion import (
    AttitudeBoundedRate,
    AttitudeWhiteJerk,
    TipBoundedVelocity,
    TipMatern,
    TipWhiteJerk,
)
from models.paper import Paper
from models.pen_config import PenConfig, Prior
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.contact import Contact
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera
from models.sensor_kinds.table import SENSOR_KINDS
from models.sensor_kinds.writing_area import WritingArea
from models.units import UNITS, accepted_names, readable_unit, split_unit
from tests.models.pens import ACCELEROMETER, CAMERA, GYROSCOPE

CHAIN_CONFIGS = (
    *(TipWhiteJerk, TipBoundedVelocity, TipMatern),
    *(AttitudeWhiteJerk, AttitudeBoundedRate),
)
G = 9.80665
TURN = 2 * np.pi
WORTH = {
    "m": 1, "cm": 1 / 100, "mm": 1 / 1000,
    "m_s": 1, "mm_s": 1 / 1000,
    "m_s2": 1, "g": G, "mg": G / 1000,
    "rad": 1, "deg": TURN / 360,
    "rad_s": 1, "deg_s": TURN / 360,
    "rad_s2": 1, "deg_s2": TURN / 360,
    "s": 1, "ms": 1 / 1000, "us": 1 / 1_000_000,
    "hz": 1, "khz": 1000,
    "ut": 1, "t": 1_000_000, "mt": 1000, "nt": 1 / 1000, "gauss": 100, "mgauss": 1 / 10,
    "ut_per_sqrt_s": 1, "mgauss_per_sqrt_s": 1 / 10,
    "m_s2_per_sqrt_hz": 1, "ug_per_sqrt_hz": G / 1_000_000,
    "rad_s_per_sqrt_hz": 1, "deg_s_per_sqrt_hz": TURN / 360, "mdeg_s_per_sqrt_hz": TURN / 360_000,
    "m_s2_per_sqrt_s": 1, "mg_per_sqrt_s": G / 1000,
    "rad_s_per_sqrt_s": 1, "deg_s_per_sqrt_s": TURN / 360,
    "m_s3_per_sqrt_hz": 1,
    "rad_s3_per_sqrt_hz": 1, "deg_s3_per_sqrt_hz": TURN / 360,
}  # fmt: skip
"""What one of each unit is in SI (a field in µT), written down a second time."""


def test_every_unit_is_worth_what_it_says() -> None:
    table = {unit: factor for row in UNITS.values() for unit, factor in row.items()}
    assert table == pytest.approx(WORTH, rel=1e-15)
    assert sum(len(row) for row in UNITS.values()) == len(table)  # no unit in two rows
    assert all(row[si] == 1.0 for si, row in UNITS.items())


@pytest.mark.parametrize(
    ("config", "others", "spelling", "field", "si"),
    [
        (Accelerometer, ACCELEROMETER, {"range_g": 2.0}, "range_m_s2", 2 * G),
        (Accelerometer, ACCELEROMETER, {"range_mg": 500}, "range_m_s2", G / 2),
        (Accelerometer, ACCELEROMETER, {"resolution_mg": 0.061}, "resolution_m_s2", 61e-6 * G),
        (Accelerometer, ACCELEROMETER, {"delay_ms": 45.0}, "delay_s", 0.045),
        (Accelerometer, ACCELEROMETER, {"rate_khz": 1.6}, "rate_hz", 1600.0),
        (Gyroscope, GYROSCOPE, {"range_deg_s": 180}, "range_rad_s", np.pi),
        (Gyroscope, GYROSCOPE, {"bias_std_deg_s": 90}, "bias_std_rad_s", np.pi / 2),
        (PoseCamera, CAMERA, {"delay_us": 500.0}, "delay_s", 0.0005),
        (Contact, {"std_m": 1.0}, {"height_cm": 2.0}, "height_m", 0.02),
        (WritingArea, {}, {"std_cm": 30.0}, "std_m", 0.3),
        (AttitudeWhiteJerk, {}, {"jerk_density_deg_s3_per_sqrt_hz": 180.0},
         "jerk_density_rad_s3_per_sqrt_hz", np.pi),
        (Prior, {}, {"elevation_deg": 45.0}, "elevation_rad", np.pi / 4),
        (Prior, {}, {"acceleration_std_g": 1.0}, "acceleration_std_m_s2", G),
        (Prior, {}, {"velocity_std_mm_s": 250.0}, "velocity_std_m_s", 0.25),
    ],
)  # fmt: skip
def test_spellings(
    config: type[Any], others: dict[str, Any], spelling: dict[str, float], field: str, si: float
) -> None:
    in_si = config(**others, **{field: si})
    in_unit = config(**others, **spelling)
    assert getattr(in_unit, field) == pytest.approx(getattr(in_si, field), rel=1e-15)
    assert getattr(in_si, field) == si


def test_lists_are_converted_entry_by_entry() -> None:
    position: dict[str, Any] = {"position_mm": [1.0, -2, 150.0]}
    camera = PoseCamera(**CAMERA, **position)
    assert camera.position_m == pytest.approx((0.001, -0.002, 0.15), rel=1e-15)
    centre: dict[str, Any] = {"centre_cm": [10, 20, 0]}
    assert WritingArea(**centre).centre_m == pytest.approx((0.1, 0.2, 0))


@pytest.mark.parametrize(
    "config", [*SENSOR_KINDS.values(), PenConfig, Prior, *CHAIN_CONFIGS, Paper]
)
def test_no_two_fields_share_a_spelling(config: type[Any]) -> None:
    """Else a key would silently set one of them."""
    spellings = [name for field in config.model_fields for name in accepted_names(field)]
    assert len(set(spellings)) == len(spellings)
    for field in config.model_fields:
        assert {config.field_of(name) for name in accepted_names(field)} == {field}
    assert config.field_of("colour") == "colour"


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("range_m_s2", "range", "m_s2"),
        ("noise_density_rad_s_per_sqrt_hz", "noise_density", "rad_s_per_sqrt_hz"),
        ("bias_walk_m_s2_per_sqrt_s", "bias_walk", "m_s2_per_sqrt_s"),
        ("delay_s", "delay", "s"),
        ("velocity_std_m_s", "velocity_std", "m_s"),
        ("azimuth_rate_rad_s", "azimuth_rate", "rad_s"),
        ("degrees_of_freedom", "degrees_of_freedom", ""),
        ("sensor_to_body", "sensor_to_body", ""),
        ("range_g", "range_g", ""),
    ],
)
def test_the_longest_unit_ends_the_name(name: str, stem: str, unit: str) -> None:
    assert split_unit(name) == (stem, unit)


@pytest.mark.parametrize("config", [Accelerometer(**ACCELEROMETER), Prior(), AttitudeWhiteJerk()])
def test_configurations_are_frozen(config: Any) -> None:
    field = next(iter(type(config).model_fields))
    with pytest.raises(ValidationError, match="frozen"):
        setattr(config, field, 1.0)


def test_units_as_people_write_them() -> None:
    pairs = {"m_s2": "m/s²", "rad_s": "rad/s", "rad_s2": "rad/s²", "m": "m", "ut": "µT"}
    assert {unit: readable_unit(unit) for unit in pairs} == pairs
