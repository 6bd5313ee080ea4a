"""A pen file with other numbers: its comments, order and units stay."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pen_mhe as pm
from models.bundled import bundled_pens
from models.pen_file import parse_pen
from pen_mhe.tuning.parameters import Parameter, parameters_of, with_values
from pen_mhe.tuning.pen_text import PenText

TIP_SPEED = Parameter("chain", ("motion", "tip"), "speed_m_s")
TURNING = Parameter("chain", ("motion", "attitude"), "jerk_density_rad_s3_per_sqrt_hz")
CAMERA = Parameter("noise", ("sensors", "camera"), "orientation_std_rad", True)
NOISE = Parameter("noise", ("sensors", "accel"), "noise_density_m_s2_per_sqrt_hz")
NOTE = ["flatness set these numbers:"]

SHORT = """# A pen.

name = "short"  # of mine
[sensors.accel]   # on the board
preset = "LSM6DS3-accelerometer"
bias_std_m_s2 = 0.3
# behind it
[sensors.camera]
kind = "pose_camera"
position_std_mm = 1
orientation_std_deg = 0.5 # a guess
"""


def rewritten(text: str, values: dict[Parameter, float]) -> str:
    """Return the text with other values; it is what the pen with these values is."""
    read = PenText(text, "pen file test.toml")
    values = {parameter: read.written(parameter, value) for parameter, value in values.items()}
    pen = with_values(parse_pen(tomllib.loads(text)), values)
    return read.replaced(values, pen, NOTE)


def changes(before: str, after: str) -> list[str]:
    lines = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in lines if line[0] in "+-"]


def test_numbers_are_replaced_where_they_stand() -> None:
    after = rewritten(SHORT, {CAMERA: 0.012345678})
    assert changes(SHORT, after) == [
        "+ #",
        "+ # flatness set these numbers:",
        "+ #   sensors.camera.orientation_std_deg = 0.7074",
        "- orientation_std_deg = 0.5 # a guess",
        "+ orientation_std_deg = 0.7074 # a guess",
    ]


def test_a_number_of_a_preset_is_added_to_its_table_in_the_units_of_the_preset() -> None:
    after = rewritten(SHORT, {NOISE: 0.002})
    added = "+ noise_density_ug_per_sqrt_hz = 203.9"
    assert added in changes(SHORT, after)
    assert after.index("bias_std") < after.rindex(added[2:]) < after.index("# behind it")


def test_a_motion_that_the_file_leaves_to_the_default_is_written_whole() -> None:
    after = rewritten(SHORT, {TURNING: 30.0})
    assert after.endswith(
        '[motion.attitude]\nchain = "white_jerk"\njerk_density_rad_s3_per_sqrt_hz = 30.0\n'
    )
    assert "[motion.tip]" not in after


@pytest.mark.filterwarnings("ignore:.process_noise. is read:FutureWarning")
def test_an_old_table_of_process_noise_becomes_a_motion() -> None:
    old = f"{SHORT}[process_noise]\ntip_jerk_density_m_s3_per_sqrt_hz = 50.0\n"
    after = rewritten(old, {TURNING: 30.0})
    assert "process_noise" not in after
    assert "jerk_density_m_s3_per_sqrt_hz = 50.0" in after
    assert "jerk_density_rad_s3_per_sqrt_hz = 30.0" in after


def test_a_second_tuning_replaces_the_note_on_a_key() -> None:
    once = rewritten(SHORT, {CAMERA: 0.01, NOISE: 0.002})
    twice = rewritten(once, {CAMERA: 0.02})
    assert twice.count("#   sensors.camera.orientation_std_deg") == 1
    assert twice.count("#   sensors.accel.noise_density_ug_per_sqrt_hz") == 1


def test_all_of_a_bundled_pen() -> None:
    text = bundled_pens()["dpoint"].read_text("utf-8")
    pen = pm.load_pen("dpoint")
    values = {p: 1.5 * p.value(pen) for p in parameters_of(pen, ["accel", "gyro", "camera"])}
    after = rewritten(text, values)
    changed = [line for line in changes(text, after) if line[2:3] != "#"]
    assert len(changed) == 2 * len(values)
    found = parse_pen(tomllib.loads(after))
    for parameter, value in values.items():
        assert parameter.value(found) == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        SHORT.replace("[sensors.camera]", "[sensors]\n[sensors.camera]").replace(
            'kind = "pose_camera"\nposition_std_mm = 1\norientation_std_deg = 0.5 # a guess\n', ""
        ),
        'name = "inline"\nsensors.camera = {kind = "pose_camera", position_std_mm = 1, '
        "orientation_std_deg = 0.5}\n",
    ],
)
def test_what_cannot_be_replaced_is_refused(text: str) -> None:
    if "inline" not in text:
        text += 'kind = "pose_camera"\nposition_std_mm = 1\n"orientation_std_deg" = 0.5\n'
    with pytest.raises(pm.InputError, match=r"test\.toml: its numbers cannot be replaced"):
        rewritten(text, {CAMERA: 0.01})


def test_lists_are_replaced_and_added() -> None:
    bias = Parameter("still", ("sensors", "accel"), "bias_m_s2")
    matrix = Parameter("still", ("sensors", "accel"), "sensitivity")
    rows = ((1.0012345678, 0.0, -1.23456789e-5), (0.0, 0.99, 0.0), (0.0, 0.0, 1.0))
    before = SHORT.replace("bias_std", "bias_mg = [1, 2, 3] # old\nbias_std")
    after = rewritten(before, {bias: (0.0980665, 0.0, -0.0196133), matrix: rows})
    assert [line for line in changes(before, after) if not line[2:].startswith("#")] == [
        "- bias_mg = [1, 2, 3] # old",
        "+ bias_mg = [10.0, 0.0, -2.0] # old",
        "+ sensitivity = [[1.00123, 0.0, -1.23457e-05], [0.0, 0.99, 0.0], [0.0, 0.0, 1.0]]",
    ]


def test_keys_on_top_and_matrices_are_written_too(tmp_path: Path) -> None:
    text = bundled_pens()["dpoint"].read_text("utf-8")
    pen, written = pm.load_pen("dpoint"), PenText(text, "pen file dpoint")
    turned = Rotation.from_rotvec([0.01, -0.02, 0.03]).as_matrix()
    values = {
        Parameter("mounting", (), "level_rad"): (0.01, -0.002),
        Parameter("mounting", (), "gravity_m_s2"): 9.81,
        Parameter("mounting", ("sensors", "gyro"), "sensor_to_body"): tuple(
            map(tuple, turned.tolist())
        ),
        Parameter("mounting", ("sensors", "camera"), "delay_s"): 0.0471234,
    }
    values = {p: written.written(p, value) for p, value in values.items()}
    new = written.replaced(values, with_values(pen, values), ["set by hand:"])
    (tmp_path / "new.toml").write_text(new, "utf-8")
    told = pm.load_pen(tmp_path / "new.toml")
    np.testing.assert_allclose(told.level_rad, [0.01, -0.002], rtol=1e-5)
    assert told.gravity_m_s2 == 9.81
    assert told.sensors["camera"].delay_s == pytest.approx(0.04712)
    np.testing.assert_allclose(told.sensors["gyro"].sensor_to_body, turned, atol=1e-8)  # type: ignore[attr-defined]
    above = new[: new.index("[motion.tip]")]
    assert "\nlevel_deg = [0.572958, -0.114592]\n" in above
    assert "\ndelay_ms = 47.12\n" in new
