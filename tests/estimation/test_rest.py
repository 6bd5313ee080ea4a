"""When inertial readings say that a pen rests, and when they must not."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.rest import GAP, LARGEST_BIAS, PATIENCE, rest_axes
from estimation.rest_detector import RestDetector
from models.arrays import Array
from models.pen import pen_model
from tests.estimation.resting import (
    INERTIAL,
    columns,
    inertial,
    instants,
    model_at_rest,
    pen_at_rest,
    pen_without_rest,
    rests,
)

MODEL = model_at_rest()
WINDOW_S = 1.05
"""With the block that is being filled; rest is found from then on."""
STILL = instants(3.0)
DEG = np.pi / 180


def sine(time_s: Array, amplitude: float, hz: float = 10.0) -> Array:
    """Return one axis that trembles (n, 3)."""
    wave = amplitude * np.sin(2 * np.pi * hz * time_s)
    return np.column_stack([wave, 0 * wave, 0 * wave])


def after(time_s: Array, start_s: float) -> Array:
    """Return 1 from an instant on (n, 1)."""
    return (time_s >= start_s)[:, None].astype(float)


@pytest.mark.parametrize("seed", range(20))
def test_a_still_pen_rests(seed: int) -> None:
    """With biases up to three deviations, 99.5 % of the time after the first window."""
    bias = 3 * DEG * np.random.default_rng(seed).uniform(-1, 1, 3) / np.sqrt(3)
    found = rests(MODEL, STILL, inertial(MODEL, STILL, seed, bias_rad_s=bias))
    assert not found[STILL < 1.0].any()
    assert found[STILL > WINDOW_S].mean() >= 0.995


@pytest.mark.parametrize("rate_hz", [20.0, 52.0, 400.0])
def test_at_any_rate(rate_hz: float) -> None:
    time_s = instants(2.0, rate_hz)
    found = rests(MODEL, time_s, inertial(MODEL, time_s, 1))
    assert found[time_s > 1.5].mean() >= 0.995


def test_with_stamps_that_tremble_and_readings_that_get_lost() -> None:
    rng = np.random.default_rng(2)
    time_s = np.cumsum(rng.uniform(0.002, 0.018, 300))
    y = inertial(MODEL, time_s, 2)
    y[rng.random(300) < 0.2, columns(MODEL, "accel")] = np.nan
    y[rng.random(300) < 0.2, columns(MODEL, "gyro")] = np.nan
    found = rests(MODEL, time_s, y)
    has_rate = np.isfinite(y[:, columns(MODEL, "gyro")]).all(axis=1)
    late = time_s > time_s[0] + 1.2
    assert found[late & has_rate].all()
    assert not found[~has_rate].any()  # a rate is said where there is a rate


@pytest.mark.parametrize(
    ("acceleration", "rate", "within_s"),
    [(0.5, 0.0, 0.01), (0.1, 0.0, 0.01), (0.0, 5 * DEG, 0.01), (0.0, 0.5 * DEG, 0.01)],
)
def test_off_when_picked_up(acceleration: float, rate: float, within_s: float) -> None:
    moved = after(STILL, 2.0) * [1.0, 0.0, 0.0]
    y = inertial(MODEL, STILL, 3, acceleration=acceleration * moved, rate=rate * moved)
    found = rests(MODEL, STILL, y)
    assert found[(STILL > WINDOW_S) & (STILL < 2.0)].all()
    assert not found[2.0 + within_s <= STILL].any()


def test_a_slow_lift_ends_rest_before_half_a_degree_a_second() -> None:
    """The rate grows by 2 °/s²; tilting shows in the accelerometer, too, but is left out."""
    rate = 2 * DEG * np.maximum(STILL - 2.0, 0)[:, None] * [1.0, 0.0, 0.0]
    found = rests(MODEL, STILL, inertial(MODEL, STILL, 4, rate=rate))
    assert not found[STILL > 2.25].any()


@pytest.mark.parametrize(
    ("acceleration", "rate", "expected"),
    [(0.02, 0.0, 1.0), (0.04, 0.0, 0.0), (0.0, 0.15 * DEG, 1.0), (0.0, 0.3 * DEG, 0.0)],
)
def test_how_much_trembling_hides_rest(acceleration: float, rate: float, expected: float) -> None:
    """3.2 deviations of the noise in amplitude: 7 µm at 10 Hz, or 0.2 °/s. A hand has more."""
    waves = {"acceleration": sine(STILL, acceleration), "rate": sine(STILL, rate)}
    found = rests(MODEL, STILL, inertial(MODEL, STILL, 5, **waves))
    assert found[STILL > WINDOW_S].mean() == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("hz", [8.0, 10.0, 12.0])
@pytest.mark.parametrize(("tip_m", "rate"), [(5e-5, 0.5 * DEG), (5e-4, 3 * DEG)])
def test_a_hand_that_trembles_is_no_rest(hz: float, tip_m: float, rate: float) -> None:
    acceleration = sine(STILL, tip_m * (2 * np.pi * hz) ** 2, hz)
    y = inertial(MODEL, STILL, 6, acceleration=acceleration, rate=sine(STILL, rate, hz))
    assert not rests(MODEL, STILL, y).any()


@pytest.mark.parametrize(("turn", "expected"), [(3.0, 1.0), (3.9, 1.0), (4.2, 0.0)])
def test_a_turn_about_the_vertical_that_is_taken_for_bias(turn: float, expected: float) -> None:
    """Known limit: no reading tells a steady turn of up to four deviations of the bias from it."""
    found = rests(MODEL, STILL, inertial(MODEL, STILL, 7, rate=turn * DEG * np.eye(3)[2]))
    assert found[STILL > WINDOW_S].mean() == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("turn", [0.2, 1.0, 3.0])
def test_a_turn_after_rest_is_none(turn: float) -> None:
    """What the rate was at rest is known: a bias does not walk so far in seconds."""
    time_s = instants(8.0)
    rate = turn * DEG * after(time_s, 2.0) * np.eye(3)[2]
    found = rests(MODEL, time_s, inertial(MODEL, time_s, 19, rate=rate))
    assert found[(time_s > WINDOW_S) & (time_s < 2.0)].all()
    assert not found[time_s > 2.25].any()


def test_a_bias_that_jumped_is_one_in_the_end() -> None:
    time_s = instants(5 + PATIENCE, 25.0)
    jump = 1.0 * DEG * after(time_s, 2.0) * np.eye(3)[2]
    found = rests(MODEL, time_s, inertial(MODEL, time_s, 20, bias_rad_s=jump))
    waits = (1 + PATIENCE) * 1.0
    assert not found[(time_s > 2.1) & (time_s < 1.9 + waits)].any()
    assert found[time_s > 2.6 + waits].all()


def test_a_slow_tilt_is_none() -> None:
    """Gravity turns by 0.2 °/s: less than any bias, but the halves of the window differ."""
    angle = 0.2 * DEG * STILL
    turned = 9.81 * np.column_stack([np.sin(angle), 0 * angle, np.cos(angle) - 1])
    found = rests(MODEL, STILL, inertial(MODEL, STILL, 8, acceleration=turned, rate=0.2 * DEG))
    assert not found.any()


def test_a_known_bias_is_no_turn() -> None:
    """Eight deviations away from zero, and told so; beside one that is not told."""
    pen = pen_at_rest()
    gyro = pen.sensors["gyro"].model_copy(update={"bias_rad_s": (0.0, 8 * DEG, 0.0)})
    told = pen_model(pen.model_copy(update={"sensors": {**pen.sensors, "gyro": gyro}}), INERTIAL)
    y = inertial(MODEL, STILL, 21, bias_rad_s=8 * DEG * np.eye(3)[1])
    assert rests(told, STILL, y)[STILL > WINDOW_S].mean() == pytest.approx(1.0, abs=0.02)
    assert not rests(MODEL, STILL, y).any()


def test_a_largest_bias_of_ones_own() -> None:
    model = model_at_rest(largest_bias_deg_s=0.5)
    assert rest_axes(model).largest_square == pytest.approx([(0.5 * DEG) ** 2])
    assert rest_axes(MODEL).largest_square == pytest.approx([(LARGEST_BIAS * DEG) ** 2])
    y = inertial(model, STILL, 9, bias_rad_s=0.6 * DEG * np.eye(3)[0])
    assert not rests(model, STILL, y).any()
    assert rests(MODEL, STILL, y).any()


@pytest.mark.parametrize("hole_s", [0.9 * GAP, 1.2 * GAP])
def test_a_hole_begins_anew(hole_s: float) -> None:
    kept = (STILL < 1.5) | (1.5 + hole_s < STILL)
    time_s, y = STILL[kept], inertial(MODEL, STILL, 10)[kept]
    found = rests(MODEL, time_s, y)
    soon = (time_s > 1.5) & (time_s < 1.5 + hole_s + 0.95)
    assert found[soon].all() if hole_s < GAP else not found[soon].any()
    assert found[time_s > 1.5 + hole_s + WINDOW_S].all()


def test_a_reading_at_its_limit_begins_anew() -> None:
    y = inertial(MODEL, STILL, 11)
    y[150, columns(MODEL, "accel")] = [40.0, 0.0, 0.0]
    found = rests(MODEL, STILL, y)
    assert found[149]
    assert not found[150:245].any()
    assert found[(STILL > 1.5 + WINDOW_S)].all()


@pytest.mark.parametrize("name", INERTIAL)
def test_a_stuck_sensor_is_none(name: str) -> None:
    y = inertial(MODEL, STILL, 12)
    y[:, columns(MODEL, name)] = y[0, columns(MODEL, name)]
    assert not rests(MODEL, STILL, y).any()


def test_coarse_steps_may_repeat() -> None:
    """A gyroscope whose steps hide its noise reads the same for long."""
    pen = pen_at_rest()
    gyro = pen.sensors["gyro"].model_copy(update={"resolution_rad_s": 0.01})
    model = pen_model(pen.model_copy(update={"sensors": {**pen.sensors, "gyro": gyro}}), INERTIAL)
    y = inertial(model, STILL, 13)
    assert np.ptp(y[:, columns(model, "gyro")]) == 0
    assert rests(model, STILL, y)[STILL > WINDOW_S].all()


def test_one_silent_sensor_is_none() -> None:
    y = inertial(MODEL, STILL, 14)
    y[:, columns(MODEL, "accel")] = np.nan
    assert not rests(MODEL, STILL, y).any()


def test_an_absurd_reading_passes() -> None:
    """Its square overflows: no rest while it is in the window, and nothing stays behind."""
    y = inertial(MODEL.replace(sensors=MODEL.sensors), STILL, 15)
    model = MODEL
    y[120, columns(model, "gyro")] = 4.2  # within its range
    found = rests(model, STILL, y)
    assert not found[120:220].any()
    assert found[STILL > 1.2 + 1.2].all()


def test_two_inertial_units() -> None:
    """Both must be still, each by its own noise."""
    pen = pen_at_rest()
    more = {f"{name}_2": pen.sensors[name] for name in INERTIAL}
    both = pen.model_copy(update={"sensors": {**pen.sensors, **more}})
    model = pen_model(both, (*INERTIAL, *more))
    y = inertial(model, STILL, 16)
    assert rests(model, STILL, y)[STILL > WINDOW_S].all()
    y[:, columns(model, "gyro_2")] += sine(STILL, 1 * DEG)
    assert not rests(model, STILL, y).any()


def test_what_is_told_is_not_detected() -> None:
    y = inertial(MODEL, STILL, 17)
    y[200, columns(MODEL, "still")] = 0
    found = rests(MODEL, STILL, y)
    assert found[199]
    assert found[200]
    assert not found[201:].any()


def test_a_state_continued_gives_the_same() -> None:
    y, detector = inertial(MODEL, STILL, 18), RestDetector(MODEL)
    memory, kept = detector.first(), None
    for k in range(200):
        before = memory.copy()
        after_step, _ = detector.step(memory, 0.01, y[k])
        assert (memory == before).all()
        memory = after_step
        kept = memory.copy() if k == 99 else kept
    assert kept is not None
    for k in range(100, 200):
        kept, _ = detector.step(kept, 0.01, y[k])
    assert (kept == memory).all()


def test_memory_depends_on_no_rate() -> None:
    assert RestDetector(MODEL).layout.size == 6 + 6 + 9 + 3 * 9 * 6
    assert RestDetector(pen_model(pen_without_rest(), INERTIAL)).layout.size == 0
