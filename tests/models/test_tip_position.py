"""Where the tip is, told by a tablet or by ultrasound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pen_mhe as pm
from models.errors import InputError
from models.pen_file import load_pen, parse_pen
from recordings.formats.tables import recording_to_table
from recordings.motion_list import DRAWN
from tests.models.pens import call, random_state

SENSORS = ("accel", "gyro", "tablet")
TABLET = {"axes": ["x", "y"], "std_mm": 0.1, "rate_hz": 100.0, "delay_ms": 8.0}
ULTRASOUND = {"std_mm": [0.5, 0.5, 1.0], "rate_hz": 50.0}


def tip_sensor(**keys: Any) -> Any:
    parsed = parse_pen({"name": "p", "sensors": {"it": {"kind": "tip_position", **keys}}})
    return parsed.sensors["it"]


def tablet_pen(**keys: Any) -> pm.PenConfig:
    """Return the reference pen on a tablet."""
    reference = load_pen("reference")
    sensors = {**reference.sensors, "tablet": tip_sensor(**keys)}
    return reference.model_copy(update={"sensors": sensors})


@pytest.mark.parametrize("axes", ["xyz", "xy", "zx"])
def test_it_reads_the_tip_along_its_axes(axes: str) -> None:
    std = [1e-3 * (i + 1) for i in range(len(axes))]
    pen = tablet_pen(axes=list(axes), std_m=std)
    model = pm.pen_model(pen, ["tablet"])
    x = random_state(np.random.default_rng(1), 6)
    sensor = model.sensor("tablet")
    assert call(sensor.h, x) == pytest.approx([x["xyz".index(axis)] for axis in axes])
    assert sensor.noise_std == pytest.approx(std)
    assert sensor.unit_of_axis == ("m",) * len(axes)
    has_area = "area" in {each.name for each in model.sensors}
    assert has_area == (len(axes) < 3)  # two axes leave the third without bound


def test_a_quantiser_is_noise_to_an_estimator() -> None:
    pen = tablet_pen(std_m=1e-4, resolution_m=6e-4)
    expected = np.sqrt(1e-8 + 6e-4**2 / 12)
    assert pm.pen_model(pen, ["tablet"]).sensor("tablet").noise_std == pytest.approx([expected] * 3)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"axes": ["x", "x"], "std_m": 1e-3}, "expected each axis once"),
        ({"axes": ["x", "y"], "std_m": [1e-3] * 3}, "std_m has 3 numbers for the axes x, y"),
        ({}, "std_m: is missing"),
    ],
)
def test_what_does_not_fit_is_said(keys: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        tip_sensor(**keys)


def test_a_tablet_sees_no_pen_that_is_far_away() -> None:
    """There is a reading where the tip is less than `hover_m` over the plane, and only there."""
    recording = pm.simulate(tablet_pen(**TABLET), ["tablet"], motion=DRAWN, duration_s=2.0, seed=1)
    assert recording.truth is not None
    times, _ = recording.sensor("tablet")
    x, y, z = recording.truth.states(["tip_x_m", "tip_y_m", "tip_z_m"], times).T
    over = z - 0.1 * x + 0.2 * y
    plane = {"hover_mm": 10.0, "height_m": float(np.median(over)) - 0.01, "slope": [0.1, -0.2]}
    found = pm.simulate(
        tablet_pen(**TABLET, **plane), ["tablet"], motion=DRAWN, duration_s=2.0, seed=1
    )
    seen, readings = found.sensor("tablet")
    there = ~np.isnan(readings).any(axis=1)
    np.testing.assert_array_equal(seen[there], times[over <= np.median(over) + 1e-12])
    assert 0.4 < there.sum() / len(times) < 0.6


def test_a_recording_that_never_sees_the_tip_is_read(tmp_path: Path) -> None:
    """What the simulator writes is read: the tablet's columns are there, and empty."""
    pen = tablet_pen(**TABLET, hover_mm=1.0, height_m=-1.0)
    recording = pm.simulate(pen, SENSORS, motion="handwriting", duration_s=0.5)
    recording_to_table(recording, pen).to_csv(tmp_path / "it.csv", index=False)
    assert set(pm.read_recording(tmp_path / "it.csv", pen).readings) == {"accel", "gyro"}


@pytest.mark.parametrize(
    ("keys", "tip_mm", "estimators"),
    [
        (TABLET, (0.2, 0.2), ("ekf",)),
        pytest.param(ULTRASOUND, (1.0, 1.0, 1.5), ("ekf",), marks=pytest.mark.slow),
        pytest.param(TABLET, (0.2, 0.2), ("mhe-rti",), marks=pytest.mark.slow),
        pytest.param(ULTRASOUND, (1.0, 1.0, 1.5), ("mhe-rti",), marks=pytest.mark.slow),
    ],
)
def test_tip_and_elevation_of_handwriting(
    keys: dict[str, Any], tip_mm: tuple[float, ...], estimators: tuple[str, ...]
) -> None:
    """Criterion: elevation within 1.5° (biases of 20 mg are 1.2°), RMS after the first second."""
    pen = tablet_pen(**keys)
    model = pm.pen_model(pen, SENSORS)
    for estimator in estimators:
        recording = pm.simulate(pen, SENSORS, motion="handwriting", duration_s=6.0, seed=7)
        assert recording.truth is not None
        history = pm.run(pm.create_estimator(estimator, model), recording)
        late = history.time_s >= 1.0
        names = [*(f"tip_{axis}_m" for axis in "xyz"[: len(tip_mm)]), "elevation_rad"]
        true = recording.truth.states(names, history.time_s)[late]
        found = np.column_stack([history.column(name) for name in names])[late]
        rms = np.sqrt(np.mean((found - true) ** 2, axis=0))
        assert (rms[:-1] < 1e-3 * np.array(tip_mm)).all()
        assert np.degrees(rms[-1]) < 1.5
        claimed = np.column_stack([history.std_of(name) for name in names])[late]
        assert (np.sqrt(np.mean(((found - true) / claimed) ** 2, axis=0)) < 2.5).all()
