"""The pens of the cases: how they move, and what is assumed of them."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from benchmark.configurations import CONFIGURATIONS
from benchmark.report.belief import BELIEVING
from benchmark.report.matrix import MATRIX, NO_SPIN
from models.motions import sample_motion
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from suites.pen.pen_cases import (
    MEASURED_HAND,
    PEN_CASES,
    REFERENCE,
    SPIN_IGNORED,
    WITH_IPOPT,
    WITHOUT_SPIN,
    moving_pen,
)
from suites.pen.told_pens import NEGLIGIBLE, told_pen

pytestmark = pytest.mark.usefixtures("interpreted")


def assumed_pen(case: str) -> PenConfig:
    return told_pen(PEN_CASES[case].assumed)


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
    slow, own = moving_pen(f"rigid body, speed {speed:g}"), moving_pen(WITHOUT_SPIN)
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
    for part in ("tip", "attitude"):
        of_slow, of_own = (getattr(pen.motion, part).built() for pen in (slow, own))
        assert of_slow.rate == of_own.rate == 0  # white jerk, the paper's
        assert of_slow.density / of_own.density == pytest.approx(speed**3 / speed**0.5)
    assert slow.sensors == own.sensors == load_pen("reference").sensors


def test_who_assumes_what_moves() -> None:
    freedom = {
        case: (moving_pen(case).degrees_of_freedom, assumed_pen(case).degrees_of_freedom)
        for case in PEN_CASES
    }
    assert freedom.pop(REFERENCE) == freedom.pop(WITH_IPOPT) == freedom.pop(MEASURED_HAND) == (6, 6)
    assert freedom.pop(SPIN_IGNORED) == (6, 5)
    assert set(freedom.values()) == {(5, 5)}
    for case, row in PEN_CASES.items():
        assert set(row.sensors) <= set(CONFIGURATIONS)
        assumed = row.assumed
        differs = assumed.neglects or assumed.is_printed or case == SPIN_IGNORED
        assert (moving_pen(case) != assumed_pen(case)) == differs
        if "speed" in case:
            assert assumed.speed == float(case.rpartition(" ")[2])


def test_the_answer_is_about_the_bundled_pen_as_its_file_says() -> None:
    assert assumed_pen(REFERENCE) == load_pen("reference")
    assert PEN_CASES[REFERENCE].sensors == tuple(CONFIGURATIONS)
    assert [chosen.case for chosen in MATRIX] == [REFERENCE]
    assert [chosen.case for chosen in NO_SPIN] == [WITHOUT_SPIN]
    assert BELIEVING == SPIN_IGNORED


def test_a_measured_hand_is_what_handwriting_does() -> None:
    """Velocity and acceleration of the told chain are near the RMS of those of the motion."""
    tip = assumed_pen(MEASURED_HAND).motion.tip.built()
    time_s = np.arange(0, 10, 0.01)
    played = [sample_motion("handwriting", time_s, seed=seed) for seed in range(10)]
    for told, derivative in zip(tip.stationary_std[1:], ("q_dot", "q_ddot"), strict=True):
        on_paper = np.concatenate([getattr(motion, derivative)[:, :2] for motion in played])
        assert 1 / 1.5 < told / np.sqrt(np.mean(on_paper**2)) < 1.5


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
    for field in ("acceleration_std_m_s2", "velocity_std_m_s"):
        told, true = (getattr(pen.prior, field) for pen in (assumed, moving))
        assert told == pytest.approx(NEGLIGIBLE * true)
    told, true = (pen.motion.tip.built().density for pen in (assumed, moving))
    assert told == pytest.approx(NEGLIGIBLE * true)
    # Nothing else is assumed differently.
    assert derivative(assumed, "gyro") == derivative(moving, "gyro")
    assert assumed.prior.angle_rate_std_rad_s == moving.prior.angle_rate_std_rad_s
    assert assumed.motion.attitude == moving.motion.attitude


def test_the_reference_is_what_a_neglecting_pen_is_compared_with() -> None:
    for case, row in PEN_CASES.items():
        if row.assumed.neglects:
            speed = row.assumed.speed
            like = WITHOUT_SPIN if speed == 1 else f"rigid body, speed {speed:g}"
            assert moving_pen(case) == moving_pen(like) == assumed_pen(like)
            assert set(row.sensors) <= set(PEN_CASES[like].sensors)
