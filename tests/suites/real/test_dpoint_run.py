"""The run on the real pen: what the camera says of the elevation, and what is judged by it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmark.tasks.task import Task
from estimation.estimator import run
from estimation.recording import Recording
from models.errors import InputError
from models.free_kinematics import attitude_of
from models.pen import pen_model
from models.pen_file import load_pen
from recordings.written import WrittenRecording
from suites.real import dpoint_run
from suites.real.cases import (
    AWAY,
    BEST,
    CAUSAL,
    LAG,
    NO_CAMERA,
    UNBIASED,
    WITH_CAMERA,
    WITHOUT_CAMERA,
    ZERO_DELAY,
)
from suites.real.dpoint_run import FOLDER, run_dpoint
from suites.real.elevation import SETTLING_S, camera_elevation, elevation_quantities
from suites.real.ingredients import INGREDIENTS, without_level
from tests.benchmark.hand_made import history

PEN = load_pen("dpoint")
LEVEL = without_level(PEN)
SHORT_S = 9.0


def recorded(elevation: np.ndarray, time_s: np.ndarray, seed: int = 0) -> Recording:
    """What a camera sees of a pen whose axis is that high above the paper."""
    rng = np.random.default_rng(seed)
    poses = np.zeros((len(time_s), 6))
    poses[:, :3] = rng.normal(0, 0.1, (len(time_s), 3))
    for row, angle in zip(poses, elevation, strict=True):
        # z of the body along the pen: from upright, tipped over, then turned about both axes.
        tipped = Rotation.from_euler("y", math.pi / 2 - angle)
        body = (
            Rotation.from_euler("z", rng.uniform(-3, 3))
            * tipped
            * Rotation.from_euler("z", rng.uniform(-3, 3))
        )
        target = body * Rotation.from_matrix(np.array(PEN.sensors["camera"].sensor_to_body))
        row[3:] = target.as_rotvec()
    return Recording("seen", time_s, {"camera": poses})


def test_the_cameras_elevation_is_that_of_the_axis() -> None:
    elevation = np.linspace(-1.5, 1.5, 61)
    times, found = camera_elevation(LEVEL, recorded(elevation, np.arange(61) / 30))
    assert np.array_equal(times, np.arange(61) / 30)
    assert found == pytest.approx(elevation, abs=1e-7)


@pytest.mark.usefixtures("interpreted")
def test_it_is_what_the_model_of_the_camera_means() -> None:
    model = pen_model(PEN, ["camera"])
    rng = np.random.default_rng(1)
    angles = rng.uniform([-3, 0.3, -3], [3, 1.4, 3], (20, 3))
    states = np.zeros((20, model.n_x))
    states[:, 3:6] = [attitude_of(*of_pose) for of_pose in angles]
    poses = np.array([np.array(model.sensor("camera").h(x)).ravel() for x in states])
    _, found = camera_elevation(LEVEL, Recording("seen", np.arange(20.0), {"camera": poses}))
    assert found == pytest.approx(angles[:, 1], abs=1e-9)


def test_spread_leaves_out_level_and_begin() -> None:
    time_s = np.arange(0, 20, 0.1)
    elevation = 0.9 + 0.2 * np.sin(time_s)
    off = math.radians(3) + math.radians(0.5) * np.sign(np.sin(7 * time_s))
    off[time_s < SETTLING_S] = 1.0
    estimated = history(["elevation_rad"], time_s, (elevation + off)[:, None])
    found = {q.name: q for q in elevation_quantities(LEVEL, estimated, recorded(elevation, time_s))}
    errors = np.degrees(off[time_s >= SETTLING_S])
    assert found["elevation"].bias == pytest.approx(errors.mean())
    assert found["elevation"].rmse == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert found["elevation_spread"].bias == pytest.approx(errors.std())
    assert found["elevation_spread"].bias == pytest.approx(0.5, rel=0.01)
    assert (found["elevation"].unit, found["elevation_spread"].unit) == ("deg", "deg")


def test_a_paper_that_is_off_level_is_levelled() -> None:
    """An axis that is upright for gravity leans in the paper's frame."""
    level = (0.02, -0.01)
    pen = PEN.model_copy(update={"level_rad": level})
    up = Rotation.from_rotvec([*level, 0.0])
    poses = np.zeros((1, 6))
    body = up * Rotation.from_euler("y", math.pi / 2 - 0.9)
    target = body * Rotation.from_matrix(np.array(PEN.sensors["camera"].sensor_to_body))
    poses[0, 3:] = target.as_rotvec()
    _, found = camera_elevation(pen, Recording("seen", np.zeros(1), {"camera": poses}))
    assert found == pytest.approx(0.9, abs=1e-12)


def test_the_unbiased_pen_differs_in_that_alone() -> None:
    unbiased, pen = (dpoint_run.VARIANTS[case](PEN) for case in (UNBIASED, NO_CAMERA))
    assert pen == LEVEL
    accel = unbiased.sensors["accel"]
    assert (accel.bias_std_m_s2, accel.bias_walk_m_s2_per_sqrt_s) == (0, 0)
    known = {name: getattr(PEN.sensors["accel"], name) for name in
             ("bias_std_m_s2", "bias_walk_m_s2_per_sqrt_s")}  # fmt: skip
    assert accel.model_copy(update=known) == PEN.sensors["accel"]
    assert {**unbiased.sensors, "accel": None} == {**PEN.sensors, "accel": None}


@pytest.mark.parametrize("name", INGREDIENTS)
def test_a_pen_without_an_ingredient_has_everything_else(name: str) -> None:
    """What is left out is there in the bundled pen, and nothing else changes."""
    less = INGREDIENTS[name](PEN)
    assert less != PEN
    for sensor, before in PEN.sensors.items():
        own = set(type(before).model_fields)
        changed = {key for key in own if getattr(less.sensors[sensor], key) != getattr(before, key)}
        assert changed <= {
            "slope": {"slope"}, "level": set(), "mounting": {"sensor_to_body"},
            "loss": {"huber", "gate_probability"},
            "tuned noise": {key for key in own if key.startswith("noise_density")},
        }[name]  # fmt: skip
    assert (less.level_rad == PEN.level_rad) == (name != "level")


def test_a_folder_without_the_recording_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has no dpoint_pen, expected it there"):
        run_dpoint(Task("real", NO_CAMERA, "accel", "ekf", 0), str(tmp_path))


@pytest.fixture
def first_seconds(dpoint_folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The data folder; runs on it see the first seconds only."""
    whole = dpoint_run._recording(str(dpoint_folder.parent))
    recording, keep = whole.recording, whole.recording.time_s <= SHORT_S
    short = replace(
        recording,
        time_s=recording.time_s[keep],
        readings={name: values[keep] for name, values in recording.readings.items()},
    )
    monkeypatch.setattr(dpoint_run, "_recording", lambda _: WrittenRecording(short, whole.ink))
    return str(dpoint_folder.parent)


@pytest.mark.parametrize("case", [*CAUSAL, "zero delay, 3 Hz"])
def test_the_camera_is_thinned_and_judged_by_what_is_left_out(
    first_seconds: str, case: str
) -> None:
    rate_hz = {**CAUSAL, **ZERO_DELAY}[case].rate_hz
    outcome = run_dpoint(Task("real", case, "accel+gyro+camera", "ekf", 0), first_seconds)
    found = {quantity.name: quantity for quantity in outcome.quantities}
    assert 0 < found["ink"].bias < 0.6
    halves = found["ink, first half"].bias, found["ink, second half"].bias
    assert sum(halves) / 2 == pytest.approx(found["ink"].bias, rel=0.01)
    assert ("left_out_position" in found) == (rate_hz < 30)
    if rate_hz < 30:
        assert 0 < found["left_out_position"].bias < 3
        assert 0 < found["left_out_orientation"].bias < 3
    assert [series.quantity for series in outcome.series] == ["tip_x", "tip_y"]
    assert outcome.solved_fraction == 1
    other = run_dpoint(Task("real", "zero delay, 15 Hz", "camera", "ekf", 1), first_seconds)
    assert other.series == ()


def test_arrivals_and_looking_back(first_seconds: str) -> None:
    task = Task("real", "causal, 10 Hz", BEST, "mhe-rti", 0)
    late, told = run_dpoint(task, first_seconds), run_dpoint(task, first_seconds, looks_back=True)
    zero = run_dpoint(replace(task, case="zero delay, 10 Hz"), first_seconds)
    ink, back, none = (
        {quantity.name: quantity.bias for quantity in found.quantities}
        for found in (late, told, zero)
    )
    assert f"ink_{LAG}" not in ink
    assert back[f"ink_{LAG}"] < back["ink"] == pytest.approx(ink["ink"], abs=0.01)
    assert none["left_out_position"] < ink["left_out_position"]
    assert late.solved_fraction == told.solved_fraction == 1


def test_the_camera_looks_away_where_the_seed_says(first_seconds: str) -> None:
    tasks = [Task("real", AWAY, BEST, "ekf", seed) for seed in (0, 0, 1)]
    first, again, other = (run_dpoint(task, first_seconds).quantities for task in tasks)
    assert first == again != other
    assert [quantity.name for quantity in first] == ["left_out_position", "left_out_orientation"]
    assert 0 < first[0].bias < 10


def test_without_a_camera_the_estimator_is_not_given_one(
    first_seconds: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[set[str]] = []

    def spied(estimator: Any, recording: Recording, **more: bool) -> Any:
        given.append({name for name, y in recording.readings.items() if np.isfinite(y).any()})
        return run(estimator, recording, **more)

    monkeypatch.setattr(dpoint_run, "run", spied)
    for case in (NO_CAMERA, UNBIASED):
        outcome = run_dpoint(Task("real", case, "accel+gyro", "ekf", 0), first_seconds)
        found = {quantity.name: quantity.bias for quantity in outcome.quantities}
        assert set(found) == {"elevation", "elevation_spread"}
        assert found["elevation_spread"] < 3
        (series,) = outcome.series
        assert series.truth is not None
        assert np.abs(series.truth - 55).max() < 35
    run_dpoint(Task("real", "zero delay, 3 Hz", "camera", "ekf", 0), first_seconds)
    assert given == [{"accel", "gyro"}] * 2 + [{"camera", "clock"}]


def test_names() -> None:
    assert FOLDER == "dpoint_pen"
    assert not set(WITH_CAMERA) & set(WITHOUT_CAMERA)
    for name, sensors in {**WITH_CAMERA, **WITHOUT_CAMERA}.items():
        assert name == "+".join(sensors)
        assert set(sensors) <= set(PEN.sensors)
