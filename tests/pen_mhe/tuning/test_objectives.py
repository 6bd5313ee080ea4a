"""What numbers are judged by, against short formulas; and what is refused for want of data."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

import pen_mhe as pm
from models.rotation import world_to_body as to_body
from pen_mhe.tuning.flatness import plane_spread_m
from pen_mhe.tuning.gaps import GAPS_S, SEEN_S, camera_elevation, gap_passes
from pen_mhe.tuning.levels import LevelFilter
from pen_mhe.tuning.likelihood import log_likelihood
from pen_mhe.tuning.objectives import OBJECTIVES
from pen_mhe.tuning.parts import SETTLING_S, ScoredPart
from pen_mhe.tuning.run import tune
from tests.pen_mhe.tuning.pens import bounded_pen

pytestmark = pytest.mark.usefixtures("interpreted")
SENSORS = ["accel", "gyro", "camera"]


@pytest.fixture(scope="module")
def recording() -> pm.Recording:
    """A hand for ten seconds; the tip touches in every other fifth of a second."""
    pen = bounded_pen()
    drawn = pm.simulate_model(pm.pen_model(pen, SENSORS), duration_s=10.0, seed=4)
    parts = {name: drawn.sensor(name) for name in SENSORS}
    times = parts["accel"][0]
    touch = times[(times % 0.4) < 0.2]
    parts["contact"] = (touch, np.zeros((len(touch), 1)))
    return pm.Recording.from_sensors("hand", parts, truth=drawn.truth)


def test_likelihood_is_the_sum_of_normal_densities(recording: pm.Recording) -> None:
    model = pm.pen_model(bounded_pen(), SENSORS)
    used = recording.select(SENSORS).first(0.5)
    history = pm.run(pm.create_estimator("ekf", model), used, covariances=True)
    expected = 0.0
    for v, S in zip(history.innovation, history.innovation_covariance, strict=True):
        rows = ~np.isnan(v)
        if rows.any():
            expected += multivariate_normal.logpdf(v[rows], cov=S[np.ix_(rows, rows)])
    assert (~np.isnan(history.innovation)).sum(axis=1).min() < model.n_r  # some have gaps
    found = log_likelihood(history, model.measured_rows)
    assert found == pytest.approx(expected, abs=1e-6)


def test_a_plane_that_slopes_is_no_error() -> None:
    random = np.random.default_rng(0)
    xy = random.uniform(-0.1, 0.1, (5000, 2)) + np.array([3.0, -2.0])
    flat = 0.2 + xy @ [0.05, -0.03]
    assert plane_spread_m(np.column_stack([xy, flat])) < 1e-15
    rough = flat + 1e-3 * random.standard_normal(len(flat))
    assert plane_spread_m(np.column_stack([xy, rough])) == pytest.approx(1e-3, rel=0.03)


def test_elevation_of_a_frame_is_that_of_the_pen(recording: pm.Recording) -> None:
    truth = recording.truth
    assert truth is not None
    times, frames = recording.sensor("camera")
    turned = np.array(bounded_pen().sensors["camera"].sensor_to_body)  # type: ignore[attr-defined]
    [elevation] = truth.states(["elevation_rad"], times).T
    away = camera_elevation(frames, turned) - elevation
    assert np.sqrt(np.mean(away**2)) == pytest.approx(math.radians(0.5), rel=0.15)
    B = ca.evalf(to_body(ca.SX(0.3), ca.SX(0.7), ca.SX(-0.2))).full()
    turn = Rotation.from_matrix(B.T @ turned).as_rotvec()
    assert camera_elevation(np.array([[0, 0, 0, *turn]]), turned)[0] == pytest.approx(0.7)


def test_gaps_follow_each_other_with_frames_between() -> None:
    for hidden in gap_passes(2.0, 40.0):
        lengths = [high - low for low, high in hidden]
        assert set(lengths) <= set(GAPS_S)
        for (_, high), (low, _) in pairwise(hidden):
            assert low - high == pytest.approx(SEEN_S)
    firsts = [hidden[0][1] - hidden[0][0] for hidden in gap_passes(2.0, 40.0)]
    assert len(set(firsts)) == len(firsts)


def test_frames_in_gaps_are_withheld_from_the_filter(recording: pm.Recording) -> None:
    pen = bounded_pen()
    filtered = LevelFilter(pen, SENSORS)
    part = ScoredPart.of(recording, "all", pen=pen, model=filtered.base.model)
    given: list[np.ndarray] = []

    class Level:
        """A pen that never moves."""

        def __init__(self, n: int) -> None:
            self.n = n

        def column(self, _: str) -> np.ndarray:
            return np.zeros(self.n)

        std_of = column

    def spy(pen: Any, time_s: np.ndarray, y: np.ndarray, **_: Any) -> Any:
        given.append(y)
        return Level(len(y))

    score = OBJECTIVES["without-camera"].judge(part)(spy, pen)
    time_s, whole = part.stacked
    passes = gap_passes(part.counts_from_s, float(time_s[-1]))
    assert score.loss == 2.0 / sum(map(len, passes))
    np.testing.assert_array_equal(given[0], whole)  # how noisy frames are
    for gaps, y in zip(passes, given[1:], strict=True):
        inside = np.any([(time_s >= low) & (time_s < high) for low, high in gaps], axis=0)
        assert np.isfinite(whole[inside, 6:]).any()
        assert np.isnan(y[inside, 6:]).all()
        np.testing.assert_array_equal(y[~inside], whole[~inside])
        np.testing.assert_array_equal(y[:, :6], whole[:, :6])


def test_flatness_is_judged_with_fewer_frames_too(recording: pm.Recording) -> None:
    pen = bounded_pen()
    part = ScoredPart.of(recording, "all", pen=pen, model=pm.pen_model(pen, SENSORS))
    frames = []

    def spy(pen: Any, time_s: np.ndarray, y: np.ndarray, **_: Any) -> Any:
        frames.append(int(np.isfinite(y[:, 6]).sum()))
        return Sloping(len(y))

    class Sloping:
        """A tip that writes on a slope."""

        def __init__(self, n: int) -> None:
            at = np.linspace(0.0, 10.0, n)
            self.tip_x_m, self.tip_y_m = np.sin(at), np.cos(3 * at)
            self.tip_z_m = 0.1 * self.tip_x_m + 1e-3 * np.sign(np.sin(50 * at))

        def column(self, name: str) -> np.ndarray:
            return np.asarray(getattr(self, name))

    score = OBJECTIVES["flatness"].judge(part)(spy, pen)
    assert frames == [301, 101, 31]
    assert score.value == pytest.approx(1.0, rel=0.02)
    assert score.loss == pytest.approx(0.01 * score.value)


def test_each_frame_is_predicted_without_those_before_it(recording: pm.Recording) -> None:
    pen = bounded_pen()
    model = pm.pen_model(pen, SENSORS)
    part = ScoredPart.of(recording, "all", pen=pen, model=model)
    given: list[np.ndarray] = []
    std = np.array([0.5] * 12)

    class Off:
        """Innovations of one deviation where there is a reading."""

        def __init__(self, y: np.ndarray) -> None:
            self.innovation = np.where(np.isnan(y[:, :12]), np.nan, std)
            self.innovation_covariance = np.broadcast_to(np.diag(std**2), (len(y), 12, 12))

        def between(self, _: float) -> Off:
            return self

    def spy(pen: Any, time_s: np.ndarray, y: np.ndarray, **_: Any) -> Any:
        given.append(y)
        return Off(y)

    score = OBJECTIVES["frames"].judge(part)(spy, pen)
    time_s, whole = part.stacked
    at = np.flatnonzero(np.isfinite(whole[:, 6]))
    kept = [np.flatnonzero(np.isfinite(y[at, 6])) for y in given]
    assert [int(np.diff(each)[0]) for each in kept] == [3, 3, 3, 6, 6, 6, 10, 10, 10]
    assert [int(each[0]) for each in kept] == [0, 1, 2, 0, 2, 4, 0, 3, 6]
    for y in given:
        np.testing.assert_array_equal(y[:, :6], whole[:, :6])
    # Frames only: the other six rows are off as much, and do not count.
    expected = -6 * (0.5 + math.log(0.5) + 0.5 * math.log(2 * math.pi))
    assert score.value == pytest.approx(-expected)
    assert set(score.figures) == {f"nats a frame, {rate} Hz" for rate in ("10", "5", "3")}
    counted = (time_s[at] > part.counts_from_s).sum()
    assert score.loss == pytest.approx(2.0 / (counted * (1 / 3 + 1 / 6 + 1 / 10) / 3))
    proposed = {p for p in LevelFilter(pen, SENSORS).parameters if OBJECTIVES["frames"].proposes(p)}
    assert proposed
    assert not any(parameter.sees_pose for parameter in proposed)


def test_a_part_ends_where_the_other_is_scored(recording: pm.Recording) -> None:
    pen = bounded_pen()
    model = pm.pen_model(pen, SENSORS)
    first, second = (
        ScoredPart.of(recording, part, pen=pen, model=model)
        for part in ("first-half", "second-half")
    )
    middle = (recording.time_s[0] + recording.time_s[-1]) / 2
    assert first.recording.time_s[-1] < middle
    assert first.counts_from_s == recording.time_s[0] + SETTLING_S
    assert second.counts_from_s == middle + SETTLING_S
    assert second.touches_s.min() >= second.counts_from_s
    # A filter comes to the second half with what was before, as it would live.
    np.testing.assert_array_equal(second.recording.time_s, recording.time_s)
    assert first.recording.truth is None  # nobody who fits is given it
    assert second.recording.truth is None


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "objective": ({"objective": "flat"}, "objective flat is unknown"),
    "part": ({"fit": "last-half"}, "part last-half is unknown"),
    "parameter": ({"parameters": ["motion.tp"]}, "parameter motion.tp is unknown"),
    "prior": ({"parameters": ["sensors.accel.bias_std_m_s2"]}, "is unknown"),
    "no camera": (
        {"objective": "without-camera", "sensors": ["accel", "gyro"]},
        "no camera is among the sensors",
    ),
    "camera alone": (
        {"objective": "without-camera", "sensors": ["camera"]},
        "no other sensor is left",
    ),
    "no frame": (
        {"objective": "frames", "sensors": ["accel", "gyro"]},
        "objective frames: expected one camera",
    ),
    "frames alone": (
        {"objective": "frames", "sensors": ["camera"]},
        "objective frames: no other sensor is left",
    ),
    "contact": (
        {"objective": "flatness", "sensors": [*SENSORS, "contact"]},
        "sensor contact is what flatness judges by",
    ),
    "no height": (
        {"objective": "flatness", "sensors": ["accel", "gyro"], "parameters": ["motion"]},
        "nothing then sees the tip's height",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_done_is_said_in_a_sentence(case: str, recording: pm.Recording) -> None:
    options, sentence = REFUSED[case]
    with pytest.raises(pm.InputError, match=sentence):
        tune(recording, bounded_pen(), **options)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda r: r.select(SENSORS), "touches at 0 counted instants"),
        (lambda r: r.first(3.0), "lasts 1.5 s, expected more than 4 s"),
    ],
)
def test_a_recording_without_the_data_is_refused(
    change: Callable[[pm.Recording], pm.Recording], sentence: str, recording: pm.Recording
) -> None:
    with pytest.raises(pm.InputError, match=sentence):
        tune(change(recording), bounded_pen(), objective="flatness", sensors=SENSORS)


def test_a_part_has_the_arrivals_of_its_readings() -> None:
    pen = bounded_pen()
    drawn = pm.simulate(pen, SENSORS, motion="handwriting", duration_s=9.0, seed=1)
    assert "camera" in drawn.arrivals
    part = ScoredPart.of(drawn, "first-half", pen=pen, model=pm.pen_model(pen, SENSORS))
    times, arrivals = part.recording.time_s, part.recording.arrivals["camera"]
    seen = np.isfinite(arrivals)
    assert times[-1] < 4.5
    np.testing.assert_array_equal(times[seen], part.recording.sensor("camera")[0])
    np.testing.assert_array_equal(arrivals, drawn.arrivals["camera"][: len(times)])
