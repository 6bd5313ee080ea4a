"""Names in pen files and tables, and in whatever they are printed into."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.folder import export_files
from estimation.native import STRICT, compiler
from models.bundled import sensor_names
from models.errors import InputError
from models.escaped import c_string, code_span, in_comment, in_markdown
from models.own_models import OwnSensor, own_model
from models.pen import pen_model
from models.pen_file import load_pen, parse_pen
from models.plain_names import plain_headers
from pen_mhe.tuning.pen_text import PenText
from recordings.read import read_recording

DASHED = """
name = "dashed"
[sensors.imu-accel]
preset = "LSM6DS3-accelerometer"
[sensors."imu gyro"]
preset = "LSM6DS3-gyroscope"
"""
EVIL = '*/ #error "runs" /* \\ `rm` <script>alert(1)</script> | $x_1$ ??/ ${HOME}'


def pen(**changes: Any) -> dict[str, Any]:
    accel = {"preset": "LSM6DS3-accelerometer"}
    return {"name": "p", "sensors": {"accel": accel}, **changes}


def test_a_dash_or_a_blank_is_an_underscore_said_once(tmp_path: Path) -> None:
    path = tmp_path / "pen.toml"
    path.write_text(DASHED)
    with pytest.warns(UserWarning, match="'imu-accel' is read as imu_accel") as said:
        config = load_pen(path)
    assert [str(one.message).count("and 1 more") for one in said] == [1]
    assert tuple(config.sensors) == sensor_names(path) == ("imu_accel", "imu_gyro")
    pen_model(config, ["imu_accel", "imu_gyro"])
    lines = ["time_s," + ",".join(f" imu-accel_{axis}_m_s2" for axis in "xyz")]
    lines += [f"{k / 100},0,0,9.81" for k in range(5)]
    (tmp_path / "pen.csv").write_text("\n".join(lines))
    with pytest.warns(UserWarning, match="column ' imu-accel_x_m_s2' is read as imu_accel") as said:
        recording = read_recording(tmp_path / "pen.csv", config)
    assert len(said) == 1
    assert list(recording.readings) == ["imu_accel"]
    text = PenText.of(path)
    assert text is not None
    assert set(text.data["sensors"]) == set(config.sensors)


def test_plain_names_are_read_in_silence() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parse_pen(pen())
        headers = ["time_s", "wind-speed", "a b"]
        assert plain_headers(headers, {"time_s", "wind-speed"}, "f") == headers


@pytest.mark.parametrize("name", ["1a", "é", "a__b", "_a", "a.b", "", "a;b", "a" * 65, "a/*"])
def test_a_name_that_none_can_be(name: str) -> None:
    sensors = {name: {"preset": "LSM6DS3-accelerometer"}}
    with pytest.raises(InputError, match="expected a letter, then letters, digits") as caught:
        parse_pen(pen(sensors=sensors))
    assert str(caught.value).isprintable()
    sensor = OwnSensor(lambda x: x, {"x": "m"}, 0.1)
    with pytest.raises(InputError, match="expected a letter, then letters, digits"):
        own_model("m", {"x": (0, 1)}, lambda x, w, dt: x, 0, {name: sensor})


def test_two_names_that_become_one() -> None:
    accel = {"preset": "LSM6DS3-accelerometer"}
    with pytest.raises(InputError, match="sensor a_b stands there twice"):
        parse_pen(pen(sensors={"a-b": accel, "a b": accel}))


@pytest.mark.parametrize("name", ["a\nb", "\x1b[31m", "", " ", "x" * 201, "\u202eevil"])
def test_a_name_for_people_is_one_printable_line(name: str) -> None:
    with pytest.raises(InputError, match=r"key name: .*printable text in one line"):
        parse_pen(pen(name=name))


def test_every_plain_name_is_one_for_casadi() -> None:
    x = ca.SX.sym("x")
    for name in ("a", "imu_accel", "A1_2b", "null", "a" * 64):
        ca.Function(f"h_{name}", [x], [x])


def test_no_name_ends_a_comment_a_string_or_a_cell() -> None:
    assert "*/" not in in_comment("**//" + EVIL + "/*/")
    assert in_comment("a\nb\\") == "a b"
    assert c_string('a"\\\n??/é') == '"a\\042\\134\\012\\077\\077/\\303\\251"'
    assert in_markdown("a|b\n<i>`c`](d)") == "a\\|b \\<i>\\`c\\`]\\(d)"
    assert code_span("a``b") == "```a``b```"
    assert code_span("`") == "`` ` ``"


def test_a_pens_name_runs_no_code(tmp_path: Path) -> None:
    """In C, CMake, Markdown and HTML."""
    unit = {"temp": EVIL}
    sensor = OwnSensor(lambda x: x, {"x": EVIL}, 0.1)
    model = own_model(EVIL, {"temp": (0, 1)}, lambda x, w, dt: x + w * dt**0.5, 1, {"t": sensor},
                      units=unit)  # fmt: skip
    export = export_texts(exportable("ekf", model))
    files = export_files(export, None, f"pen-mhe codegen --pen '{EVIL}'")
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        assert '\n#error "runs"' not in text
    cmake = [line for line in files["CMakeLists.txt"].splitlines() if "rm" in line]
    assert len(cmake) == 1
    assert cmake[0].startswith("# ")
    assert "\n<script" not in files["README.md"]
    html = model._repr_html_()
    assert "<script>" not in html
    assert "&lt;script&gt;" in html
    if compiler() is None:
        pytest.skip("no C compiler here")
    for name in ("pen.c", "main.c"):
        command = ["cc", *STRICT, "-c", name, "-o", "out.o"]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
