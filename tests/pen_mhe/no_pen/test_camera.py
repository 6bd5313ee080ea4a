"""A camera's target is found as it is turned; a frame that is not upright is left out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from pen_mhe.no_pen.pen_for import pen_for
from tests.recordings.rods import proper_mountings
from tests.references.leaning_rod import leaning_rod

MOUNTING = proper_mountings()[4]
TARGET = Rotation.from_euler("xyz", [20, -35, 70], degrees=True)
"""From the target's axes to the body's."""


def with_camera(world: Rotation) -> Recording:
    """Return a rod that a camera sees, whose frame is the world's turned."""
    rod, rng = leaning_rod(1, MOUNTING), np.random.default_rng(1)
    seen = world * rod.attitude * TARGET
    seen = seen * Rotation.from_rotvec(rng.normal(0, 0.004, (len(rod.time_s), 3)))
    poses = np.hstack([world.apply(rod.place), seen.as_rotvec()])
    poses[:, :3] += rng.normal(0, 7e-4, (len(poses), 3))
    every = slice(None, None, 3)
    return Recording.from_sensors(
        "rod",
        {
            "accel": (rod.time_s, rod.force),
            "gyro": (rod.time_s, rod.rate),
            "camera": (rod.time_s[every], poses[every]),
        },
    )


def test_the_target_is_turned_as_it_is() -> None:
    found = pen_for(with_camera(Rotation.identity()))
    camera = found.pen.sensors["camera"]
    known = np.array(found.pen.sensors["accel"].sensor_to_body)
    # About the pen's axis nobody tells where body x points: compared in the chip's axes.
    told = Rotation.from_matrix(known.T @ np.array(camera.sensor_to_body))
    true = Rotation.from_matrix(MOUNTING.T) * TARGET
    assert (told * true.inv()).magnitude() < np.radians(1.0)
    assert camera.position_std_m == pytest.approx(7e-4, rel=0.4)
    assert found.pen.level_rad == (0.0, 0.0)


def test_a_frame_that_leans_is_levelled() -> None:
    leaning = Rotation.from_euler("x", 7, degrees=True)
    level = pen_for(with_camera(leaning)).pen.level_rad
    np.testing.assert_allclose(np.degrees(level), (7.0, 0.0), atol=1.0)


def test_a_frame_whose_z_is_not_up_is_left_out() -> None:
    found = pen_for(with_camera(Rotation.from_euler("x", -90, degrees=True)))
    assert "camera" not in found.pen.sensors
    assert any("camera: left out" in note and "z is up" in note for note in found.notes)
