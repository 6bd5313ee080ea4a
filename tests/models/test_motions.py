"""Motions: exact derivatives, speed, via points, lognormal strokes, random handwriting."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import lognorm

from models.arrays import Array
from models.errors import InputError
from models.handwriting import Handwriting, SineBand
from models.minimum_jerk import MinimumJerk
from models.motions import MOTION_KINDS, motion_named, motions, parse_motions, sample_motion
from models.sigma_lognormal import LognormalStroke, SigmaLognormal

STEP_S = 5e-4
DEG = np.pi / 180
REST = (0.1, 0.9, 0.2)
LONG_AFTER_S = 1e4


def five_points(motion: str, time_s: Array) -> tuple[Array, Array]:
    """First and second differences of q in time."""
    q = {k: sample_motion(motion, time_s + k * STEP_S, seed=3).q for k in (-2, -1, 0, 1, 2)}
    first = (q[-2] - 8 * q[-1] + 8 * q[1] - q[2]) / (12 * STEP_S)
    second = (-q[-2] + 16 * q[-1] - 30 * q[0] + 16 * q[1] - q[2]) / (12 * STEP_S**2)
    return first, second


@pytest.mark.parametrize("name", motions())
def test_derivatives_are_those_of_the_path(name: str) -> None:
    time_s = np.linspace(0.01, 2.99, 500)
    config = motion_named(name)
    if isinstance(config, MinimumJerk):
        # Jerk jumps in the via points, where differences straddle two segments.
        away = np.abs(time_s[:, None] - np.array(config.time_s)).min(axis=1)
        time_s = time_s[away > 3 * STEP_S]
    motion = sample_motion(name, time_s, seed=3)
    for exact, difference in zip(
        (motion.q_dot, motion.q_ddot), five_points(name, time_s), strict=True
    ):
        largest = np.abs(exact).max(axis=0)
        # A coordinate at rest has exact zeros, and differences of its own rounding.
        scale = np.where(largest > 0, largest, 1.0)
        assert np.abs((exact - difference) / scale).max() < 1e-7


@pytest.mark.parametrize("name", motions())
@pytest.mark.parametrize("speed", [0.5, 1.7, 4.0])
def test_speed_is_exact(name: str, speed: float) -> None:
    time_s = np.linspace(0, 3, 200)
    fast, slow = (
        sample_motion(name, time_s, seed=3, speed=speed),
        sample_motion(name, speed * time_s, seed=3),
    )
    np.testing.assert_array_equal(fast.time_s, time_s)
    np.testing.assert_array_equal(fast.q, slow.q)
    np.testing.assert_array_equal(fast.q_dot, speed * slow.q_dot)
    np.testing.assert_array_equal(fast.q_ddot, speed**2 * slow.q_ddot)


def test_via_points_are_reached_at_rest() -> None:
    via = motion_named("turn")
    assert isinstance(via, MinimumJerk)
    motion = sample_motion("turn", np.array(via.time_s))
    points = np.hstack([np.array(via.tip_m), np.array(via.angles_rad)])
    np.testing.assert_allclose(motion.q, points, rtol=0, atol=1e-15)
    assert np.abs(motion.q_dot).max() < 1e-14
    assert np.abs(motion.q_ddot).max() < 1e-12
    outside = sample_motion("turn", np.array([-5.0, 99.0]))
    np.testing.assert_allclose(outside.q, points[[0, -1]], rtol=0, atol=1e-15)


def test_minimum_jerk_between_two_points() -> None:
    """Half way in the middle, with the peak speed 15/8 of the mean one."""
    via = MinimumJerk(
        description="", time_s=(1.0, 3.0), tip_m=((0, 0, 0), (0.1, 0, 0)), angles_rad=(REST, REST)
    )
    motion = sample_motion(via, np.array([2.0]))
    assert motion.name == "minimum_jerk"
    assert motion.q[0, 0] == pytest.approx(0.05, rel=1e-14)
    assert motion.q_dot[0, 0] == pytest.approx(15 / 8 * 0.05, rel=1e-14)
    assert motion.q_ddot[0, 0] == pytest.approx(0, abs=1e-14)


def lognormal_stroke(bend: float, **changes: float) -> LognormalStroke:
    values = {"t0_s": 0.2, "D_m": 0.008, "mu": -1.4, "sigma": 0.3, "start_rad": 0.7}
    values |= {"lift_m": 0.004, **changes}
    turn = (0.1, -0.2, 0.3)
    return LognormalStroke(**values, end_rad=values["start_rad"] + bend, turn_rad=turn)


def written(*strokes: LognormalStroke) -> SigmaLognormal:
    return SigmaLognormal(description="", tip_m=(0.01, 0.02, 0), angles_rad=REST, strokes=strokes)


@pytest.mark.parametrize("bend", [0.0, 1e-300, -1e-16, 1e-12, 1e-9, -1e-6, 1e-3, 0.5, -2.0, 7.0])
def test_a_stroke_is_the_integral_of_its_velocity(bend: float) -> None:
    """SciPy's lognormal distribution, and Gauss-Legendre quadrature over the progress."""
    stroke, time_s = lognormal_stroke(bend), np.linspace(-0.1, 1.5, 60)
    motion = sample_motion(written(stroke), time_s)
    law = lognorm(s=stroke.sigma, loc=stroke.t0_s, scale=np.exp(stroke.mu))
    F, speed = law.cdf(time_s), law.pdf(time_s)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    u = F[:, None] * (nodes + 1) / 2
    angle, weights = stroke.start_rad + bend * u, F[:, None] * weights / 2
    path = stroke.D_m * np.stack([(weights * f(angle)).sum(axis=1) for f in (np.cos, np.sin)], 1)
    # Rounding of the first point, 2 cm away, is 3e-18 m.
    np.testing.assert_allclose(motion.q[:, :2] - [0.01, 0.02], path, rtol=1e-13, atol=1e-17)
    phi = stroke.start_rad + bend * F
    velocity = (stroke.D_m * speed)[:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    np.testing.assert_allclose(motion.q_dot[:, :2], velocity, rtol=1e-12, atol=1e-18)
    changes = np.array([stroke.lift_m, *stroke.turn_rad])
    progress = motion.q[:, 2:] - np.array([0.0, *REST])
    np.testing.assert_allclose(progress, np.outer(F, changes), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(
        motion.q_dot[:, 2:], np.outer(speed, changes), rtol=1e-12, atol=1e-18
    )


def test_a_bend_to_nothing_is_a_straight_line() -> None:
    """First order in the bend: the tip leaves the line by D F² Δθ / 2."""
    time_s = np.linspace(0, 2, 100)
    straight = sample_motion(written(lognormal_stroke(0.0)), time_s)
    F = (straight.q[:, 2]) / 0.004
    across = np.array([-np.sin(0.7), np.cos(0.7)])
    for bend in (1e-15, 1e-11, 1e-7):
        bent = sample_motion(written(lognormal_stroke(bend)), time_s)
        aside = (bent.q - straight.q)[:, :2] @ across
        np.testing.assert_allclose(aside, 0.008 * F**2 * bend / 2, rtol=1e-6, atol=1e-17)


def test_straight_strokes_add_up_to_their_lengths() -> None:
    """However they overlap; the speeds integrate to the same length."""
    strokes = [
        lognormal_stroke(0.0, t0_s=t0, D_m=D, sigma=sigma)
        for t0, D, sigma in ((0.0, 0.01, 0.2), (0.1, 0.005, 0.4), (0.15, 0.02, 0.3))
    ]
    end = sample_motion(written(*strokes), np.array([LONG_AFTER_S]))
    moved = end.q[0, :2] - [0.01, 0.02]
    assert np.hypot(*moved) == pytest.approx(0.035, rel=1e-13)
    assert np.arctan2(moved[1], moved[0]) == pytest.approx(0.7, rel=1e-13)
    assert np.abs(end.q_dot).max() < 1e-12


def test_a_bent_stroke_has_its_length() -> None:
    config = written(lognormal_stroke(2.5))

    def speed(time_s: float) -> float:
        return float(np.hypot(*sample_motion(config, np.array([time_s])).q_dot[0, :2]))

    assert quad(speed, 0.2, 5, points=[0.4, 0.6], limit=200)[0] == pytest.approx(0.008, rel=1e-8)


def test_strokes_are_a_vector_sum() -> None:
    first, second = lognormal_stroke(1.0), lognormal_stroke(-2.0, t0_s=0.3, start_rad=2.0)
    time_s = np.linspace(0, 2, 50)
    both, one, other = (
        sample_motion(written(*strokes), time_s)
        for strokes in ((first, second), (first,), (second,))
    )
    start = np.array([0.01, 0.02, 0.0, *REST])
    np.testing.assert_allclose(both.q, one.q + other.q - start, rtol=0, atol=1e-15)
    np.testing.assert_allclose(both.q_dot, one.q_dot + other.q_dot, rtol=0, atol=1e-15)
    np.testing.assert_allclose(both.q_ddot, one.q_ddot + other.q_ddot, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["loops", "yong"])
def test_written_strokes_are_of_plausible_size(name: str) -> None:
    motion = sample_motion(name, np.linspace(0, 3, 3001))
    size = np.ptp(motion.q[:, :2], axis=0)
    assert 0.005 < size.max() < 0.02
    assert 0.05 < np.hypot(*motion.q_dot[:, :2].T).max() < 0.1
    assert motion.q[:, 2].min() > -1e-9


def test_the_pen_is_lifted_between_strokes() -> None:
    z = sample_motion("yong", np.array([0.4, 0.7, 1.0, 1.5, 3.0])).q[:, 2]
    assert (z[[0, 2, 3]] < 2e-4).all()
    assert (z[[1, 4]] > 3e-3).all()


def test_handwriting_has_the_stated_rms() -> None:
    """Over seeds, phases are uniform: E q² = rms² at any instant, E q̇² = Σ A² ω² / 2."""
    config = motion_named("handwriting")
    assert isinstance(config, Handwriting)
    n = 1500
    samples = [sample_motion(config, np.array([0.0]), seed=seed) for seed in range(n)]
    centre = np.array([*config.tip_m, *config.angles_rad])
    rms = np.array([*config.tip_rms_m, *config.angles_rms_rad])
    scaled = np.array([motion.q[0] for motion in samples] - centre) / rms
    # A sum of sines has at most the fourth moment of a Gaussian, which makes the standard
    # error of a mean square √(2/n).
    assert np.abs(np.mean(scaled**2, axis=0) - 1).max() < 4 * np.sqrt(2 / n)
    assert np.abs(np.mean(scaled, axis=0)).max() < 4 / np.sqrt(n)


def test_handwriting_moves_as_fast_as_the_recording() -> None:
    """Tip 20 and 26 mm/s while pressed, angles 17.5, 7.9 and 17.9 °/s: see motions.toml."""
    motion = sample_motion("handwriting", np.arange(0, 600, 0.05), seed=0)
    rate = np.sqrt(np.mean(motion.q_dot**2, axis=0))
    recorded = np.array([0.020, 0.026, *np.array([17.5, 7.9, 17.9]) * DEG])
    ratio = rate[[0, 1, 3, 4, 5]] / recorded
    assert ratio.min() > 0.8
    assert ratio.max() < 1.25


def test_handwriting_stays_in_its_band() -> None:
    """Rates and accelerations lie between the band's ends times the motion; the line is added."""
    bands = {
        "tip_band": SineBand(lowest_hz=1.0, highest_hz=1.5),
        "angle_band": SineBand(lowest_hz=3.0, highest_hz=4.0, sines=5),
    }
    still = {"tip_rms_m": (0, 0, 0), "angles_rms_rad": (0, 0, 0)}
    moving = {"tip_rms_m": (1, 2, 3), "angles_rms_rad": (1, 2, 3)}
    rest = {"description": "", "angles_rad": REST, "line_m": 0.1, "line_duration_s": 10.0}
    time_s = np.arange(0, 400, 0.05)
    line = sample_motion(Handwriting(**bands, **still, **rest), time_s, seed=1)
    wave = sample_motion(Handwriting(**bands, **moving, **rest), time_s, seed=1)
    lowest, highest = 2 * np.pi * np.array([[1.0] * 3 + [3.0] * 3, [1.5] * 3 + [4.0] * 3])
    q, q_dot, q_ddot = (
        np.sqrt(np.mean((getattr(wave, name) - getattr(line, name)) ** 2, axis=0))
        for name in ("q", "q_dot", "q_ddot")
    )
    assert q == pytest.approx([1, 2, 3, 1, 2, 3], rel=0.05)
    for slower, faster in ((q, q_dot), (q_dot, q_ddot)):
        assert (faster / slower > lowest).all()
        assert (faster / slower < highest).all()
    at = np.searchsorted(time_s, [0.0, 5.0, 10.0, 20.0])
    assert line.q[at, 0] == pytest.approx([0, 0.05, 0.1, 0], abs=1e-12)
    assert line.q_dot[at[[0, 2, 3]], 0] == pytest.approx([0, 0, 0], abs=1e-12)


def test_a_seed_is_one_motion_at_any_instants() -> None:
    coarse, fine = np.linspace(0, 2, 11), np.linspace(0, 2, 101)
    motion = sample_motion("handwriting", fine, seed=5)
    again = sample_motion("handwriting", coarse, seed=np.random.default_rng(5))
    other = sample_motion("handwriting", coarse, seed=6)
    np.testing.assert_allclose(motion.q[::10], again.q, rtol=0, atol=1e-14)
    assert np.abs(again.q - other.q).max() > 1e-2


def test_every_kind_has_a_motion() -> None:
    assert {motion.kind for motion in motions().values()} == set(MOTION_KINDS)


VIA = {
    "kind": "minimum_jerk",
    "description": "",
    "time_s": [0, 1],
    "tip_m": [[0, 0, 0]] * 2,
    "angles_rad": [[0, 0, 0]] * 2,
}
WRITING = motion_named("handwriting").model_dump()


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"kind": "spiral"}, "motion it: kind is spiral, expected one of minimum_jerk, sigma"),
        ({}, "kind is None, expected one of minimum_jerk"),
        (3, "kind is no table, expected one of minimum_jerk"),
        ({**VIA, "time_s": [1, 1]}, "expected increasing times of the via points"),
        ({**VIA, "time_s": [0, 1, 2]}, "got 3 times, 2 tips and 2 triples"),
        ({**VIA, "tip_inch": 1}, "unknown key tip_inch; expected tip_m or tip_cm or tip_mm"),
        (
            {"kind": "sigma_lognormal", "description": "", "angles_rad": REST},
            "key strokes: is missing",
        ),
        (
            {**WRITING, "tip_band": {"lowest_hz": 5.0, "highest_hz": 0.3}},
            "expected lowest_hz below highest_hz, got 5 and 0.3 Hz",
        ),
    ],
)
def test_a_bad_row_is_refused(row: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_motions({"it": row}, where="file")


def test_a_bad_call_is_refused() -> None:
    with pytest.raises(InputError, match="motion loop is unknown, expected one of turn, still"):
        sample_motion("loop", np.zeros(1))
    for speed in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match="expected a positive factor"):
            sample_motion("turn", np.zeros(1), speed=speed)
