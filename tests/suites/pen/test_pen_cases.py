"""The pens of the cases: how they move, and what is assumed of them."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from benchmark.configurations import CONFIGURATIONS
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from suites.pen.pen_cases import (
    NEGLIGIBLE,
    PEN_CASES,
    REFERENCE,
    WITH_SPIN,
    assumed_pen,
    moving_pen,
)

pytestmark = pytest.mark.usefixtures("interpreted")


def derivative(pen: PenConfig, sensor: str) -> dict[str, float]:
    """State → length of its column in the reading's Jacobian, at a pen that is moving."""
    model = pen_model(pen, [sensor])
    x = ca.SX.sym("x", model.n_x)
    jacobian = ca.Function("H", [x], [ca.jacobian(model.sensor(sensor).h(x), x)])
    at = np.random.default_rng(0).uniform(0.2, 0.9, model.n_x)
    columns = np.linalg.norm(np.array(jacobian(at)), axis=0)
    return dict(zip(model.state_names, columns, strict=True))


@pytest.mark.parametrize("speed", [0.1, 0.3, 3.0])
def test_what_is_known_of_the_motion_follows_its_speed(speed: float) -> None:
    """q(st) has derivatives s, s², s³ times; the density of the jerk is s³ over √s."""
    slow, own = moving_pen(f"rigid body, speed {speed:g}"), moving_pen(REFERENCE)
    powers = {
        "velocity_std_m_s": 1,
        "angle_rate_std_rad_s": 1,
        "acceleration_std_m_s2": 2,
        "angle_acceleration_std_rad_s2": 2,
    }
    for field in type(own.prior).model_fields:
        of_slow, of_own = getattr(slow.prior, field), getattr(own.prior, field)
        if field in powers:
            assert of_slow == pytest.approx(of_own * speed ** powers[field])
        else:
            assert of_slow == of_own
    for field in ("tip_jerk_density_m_s3_per_sqrt_hz", "angle_jerk_density_rad_s3_per_sqrt_hz"):
        ratio = getattr(slow.process_noise, field) / getattr(own.process_noise, field)
        assert ratio == pytest.approx(speed**3 / speed**0.5)
    assert slow.sensors == own.sensors == load_pen("reference").sensors


def test_who_assumes_what_moves() -> None:
    freedom = {
        case: (moving_pen(case).degrees_of_freedom, assumed_pen(case).degrees_of_freedom)
        for case in PEN_CASES
    }
    assert freedom.pop(WITH_SPIN) == (6, 6)
    assert freedom.pop("spin ignored") == (6, 5)
    assert set(freedom.values()) == {(5, 5)}
    for case, row in PEN_CASES.items():
        assert set(row.sensors) <= set(CONFIGURATIONS)
        assert (moving_pen(case) != assumed_pen(case)) == (row.neglects or case == "spin ignored")
        if "speed" in case:
            assert row.speed == float(case.rpartition(" ")[2])


@pytest.mark.parametrize("speed", [0.1, 0.3, 1.0, 3.0])
def test_neglecting_takes_the_accelerometer_for_gravity_alone(speed: float) -> None:
    case = f"accelerations neglected, speed {speed:g}"
    moving, assumed = moving_pen(case), assumed_pen(case)
    turning = [
        "azimuth_rate_rad_s", "elevation_rate_rad_s",
        "azimuth_acceleration_rad_s2", "elevation_acceleration_rad_s2",
    ]  # fmt: skip
    of_moving, of_assumed = derivative(moving, "accel"), derivative(assumed, "accel")
    assert min(of_moving[state] for state in turning) > 1e-3
    assert max(of_assumed[state] for state in turning) < 1e-12
    assert of_assumed["elevation_rad"] > 1
    # The tip hardly accelerates: its accelerations are still in the model, but known to be none.
    noise = "tip_jerk_density_m_s3_per_sqrt_hz"
    for part, field in (
        ("prior", "acceleration_std_m_s2"),
        ("prior", "velocity_std_m_s"),
        ("process_noise", noise),
    ):
        told, true = (getattr(getattr(pen, part), field) for pen in (assumed, moving))
        assert told == pytest.approx(NEGLIGIBLE * true)
    # Nothing else is assumed differently.
    assert derivative(assumed, "gyro") == derivative(moving, "gyro")
    assert assumed.prior.angle_rate_std_rad_s == moving.prior.angle_rate_std_rad_s
    angle = "angle_jerk_density_rad_s3_per_sqrt_hz"
    assert getattr(assumed.process_noise, angle) == getattr(moving.process_noise, angle)


def test_the_reference_is_what_a_neglecting_pen_is_compared_with() -> None:
    for case, row in PEN_CASES.items():
        if row.neglects:
            like = REFERENCE if row.speed == 1 else f"rigid body, speed {row.speed:g}"
            assert moving_pen(case) == moving_pen(like) == assumed_pen(like)
            assert set(row.sensors) <= set(PEN_CASES[like].sensors)
