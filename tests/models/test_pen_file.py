"""Pen files: what they say, what presets add, and one sentence for every mistake."""

from __future__ import annotations

import re
import warnings
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from models.bundled import bundled_pens
from models.errors import InputError
from models.motion import (
    AttitudeBoundedRate,
    Motion,
    TipBoundedVelocity,
    TipMatern,
    TipWhiteJerk,
    white_jerk_motion,
)
from models.pen import pen_model
from models.pen_file import as_pen, load_pen, parse_pen, presets
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.sensor_kinds.pose_camera import PoseCamera

G = 9.80665
DEG = np.pi / 180
DPOINT = Path(str(resources.files("models") / "pens" / "dpoint.toml"))

PEN = 'name = "p"\n[sensors.tip]\n'
ACCEL = PEN + 'kind = "accelerometer"\n'
GOOD = ACCEL + "noise_density_ug_per_sqrt_hz = 90\nbandwidth_hz = 50\n"
PLACE = {"magnetometer": {"field_strength_ut": 48.0, "field_dip_deg": 64.0}}
"""Kind → what no data sheet says of a sensor, because it is the place's."""
TIP = '[motion.tip]\nchain = "bounded_velocity"\n'
TURNED = GOOD + "sensor_to_body = "


def load(folder: Path, text: str) -> Any:
    path = folder / "my_pen.toml"
    path.write_text(text, "utf-8")
    return load_pen(path)


def sensor_from(**keys: Any) -> Any:
    return parse_pen({"name": "p", "sensors": {"it": keys}}).sensors["it"]


def test_dpoint() -> None:
    config = load_pen(DPOINT)
    assert (config.degrees_of_freedom, config.gravity_m_s2) == (6, 9.83)
    assert list(config.sensors) == ["accel", "gyro", "camera", "contact", "area"]
    accel, gyro, camera = (config.sensors[name] for name in ("accel", "gyro", "camera"))
    assert isinstance(accel, Accelerometer)
    assert accel.noise_density_m_s2_per_sqrt_hz == pytest.approx(225e-6 * G)
    assert accel.range_m_s2 == pytest.approx(4 * G)  # its own, not the preset's 2 g
    assert accel.resolution_m_s2 == pytest.approx(0.061e-3 * G)  # the preset's
    assert isinstance(gyro, Gyroscope)
    assert gyro.range_rad_s == pytest.approx(245 * DEG)
    assert gyro.bias_std_rad_s == pytest.approx(2 * DEG)
    assert isinstance(camera, PoseCamera)
    assert (camera.delay_s, camera.position_std_m) == pytest.approx((0.04789, 0.00015))
    tip, attitude = config.motion.tip, config.motion.attitude
    assert tip == TipBoundedVelocity(speed_m_s=0.08, correlation_time_s=0.1)
    assert attitude == white_jerk_motion(1.0, 20.0).attitude


def test_dpoint_as_a_model() -> None:
    model = pen_model(load_pen(DPOINT))
    assert (model.n_x, model.n_y) == (18 + 6, 3 + 3 + 6 + 1 + 3)


def test_every_preset_is_a_sensor_with_a_source() -> None:
    table = presets()
    assert len(table) >= 20
    for name, values in table.items():
        assert len(values["source"]) > 20, name
        place = PLACE.get(values["kind"], {})
        sensor = sensor_from(preset=name, **place)
        assert sensor.kind == values["kind"]
        written = {k: v for k, v in values.items() if k != "source"}
        assert sensor == sensor_from(**written, **place)
        assert 0 <= sensor.resolution < sensor.sample_std < sensor.reading_limit, name


def test_presets_are_a_copy() -> None:
    presets()["ADXL202"]["range_g"] = 1000.0
    assert presets()["ADXL202"]["range_g"] == 2.0


@pytest.mark.parametrize("override", [{"range_g": 0.5}, {"range_mg": 500}, {"range_m_s2": G / 2}])
def test_an_override_replaces_the_preset_in_any_unit(override: dict[str, float]) -> None:
    sensor = sensor_from(preset="ADXL202", **override)
    assert sensor.range_m_s2 == pytest.approx(G / 2)
    plain = sensor_from(preset="ADXL202")
    changed = sensor.model_copy(update={"range_m_s2": plain.range_m_s2})
    assert plain.range_m_s2 == pytest.approx(2 * G)
    assert changed == plain


OLD_FILE = r"ignore:\[process_noise\] is read for the last time:FutureWarning"

MISTAKES = {
    "not TOML": ("name = ", "", "expected TOML"),
    "no name": (GOOD.removeprefix('name = "p"\n'), "key name:", "is missing"),
    "unknown key": ("colour = 1\n" + GOOD, "unknown key colour;", "expected one of bounds, deg"),
    "unknown sensor key": (GOOD + "rnage_g = 2", "key sensors.tip: unknown key rnage_g;",
                           "expected one of axes, bandwidth_hz, bias_m_s2, bias_std_m_s2"),
    "wrong unit": (GOOD + "range_furlong = 2", "key sensors.tip: unknown key range_furlong;",
                   "expected range_m_s2 or range_g or range_mg"),
    "unit of another quantity": (GOOD + "range_deg_s = 2", "unknown key range_deg_s;",
                                 "expected range_m_s2 or range_g or range_mg"),
    "wrong unit in the prior": (GOOD + "[prior]\nelevation_grad = 2", "key prior:",
                                "expected elevation_rad or elevation_deg"),
    "twice": (GOOD + "range_g = 2\nrange_m_s2 = 20", "key sensors.tip:",
              "gives range_m_s2 a second time"),
    "scaled": (TURNED + "[[2,0,0],[0,1,0],[0,0,1]]", "key sensors.tip.sensor_to_body:",
               "expected a rotation matrix: its rows are not orthonormal"),
    "sheared": (TURNED + "[[1,0,0.1],[0,1,0],[0,0,1]]", "key sensors.tip.sensor_to_body:",
                "expected a rotation matrix"),
    "reflection": (TURNED + "[[1,0,0],[0,1,0],[0,0,-1]]", "key sensors.tip.sensor_to_body:",
                   "expected a rotation matrix: its determinant is -1, a reflection"),
    "two rows": (TURNED + "[[1,0,0],[0,1,0]]", "key sensors.tip.sensor_to_body.2:", "is missing"),
    "unknown kind": (PEN + 'kind = "sonar"', "key sensors.tip:", "expected tags: 'accelerometer'"),
    "missing key": (ACCEL + "bandwidth_hz = 5", "sensors.tip.noise_density_m_s2_per_sqrt_hz:",
                    "is missing"),
    "unknown preset": (PEN + 'preset = "ADXL1"', "key sensors.tip.preset: unknown preset ADXL1;",
                       "expected one of ADXL202, ADXRS150, LSM6DS3-accelerometer"),
    "four degrees of freedom": ("degrees_of_freedom = 4\n" + GOOD, "key degrees_of_freedom:",
                                "should be 5 or 6"),
    "no sensors": ('name = "p"', "key sensors:", "at least 1 item"),
    "empty sensors": ('name = "p"\n[sensors]', "key sensors:", "at least 1 item"),
    "a list of sensors": ('name = "p"\nsensors = [1]', "key sensors:", "expected a table"),
    "negative noise": (ACCEL + "bandwidth_hz = 5\nnoise_density_ug_per_sqrt_hz = -1",
                       "sensors.tip.noise_density_m_s2_per_sqrt_hz:", "greater than 0"),
    "negative delay": (GOOD + "delay_ms = -1", "tip.delay_s:", "greater than or equal to 0"),
    "NaN": (GOOD + "range_g = nan", "sensors.tip.range_m_s2:", "finite number"),
    "infinity": (GOOD + "rate_hz = inf", "sensors.tip.rate_hz:", "finite number"),
    "NaN in a list": (GOOD + "position_mm = [0, nan, 0]", "tip.position_m.1:", "finite number"),
    "NaN in a matrix": (TURNED + "[[nan,0,0],[0,1,0],[0,0,1]]", "sensor_to_body.0.0:", "finite"),
    "axis twice": (GOOD + 'axes = ["x", "x"]', "sensors.tip.axes:", "expected each axis once"),
    "no axes": (GOOD + "axes = []", "sensors.tip.axes:", "at least 1 item"),
    "unknown axis": (GOOD + 'axes = ["w"]', "sensors.tip.axes.0:", "'x', 'y' or 'z'"),
    "zero process noise": (GOOD + "[process_noise]\ntip_jerk_density_m_s3_per_sqrt_hz = 0",
                           "process_noise.tip_jerk_density_m_s3_per_sqrt_hz:", "greater than 0"),
    "zero speed": (GOOD + TIP + "speed_m_s = 0\ncorrelation_time_s = 0.1",
                   "motion.tip.speed_m_s:", "greater than 0"),
    "unknown chain": (GOOD + '[motion.tip]\nchain = "white_jurk"', "key motion.tip:",
                      "expected tags: 'white_jerk', 'bounded_velocity', 'matern'; did you mean"),
    "no chain": (GOOD + "[motion.attitude]\nrate_rad_s = 1", "key motion.attitude.chain:",
                 "is missing, expected one of white_jerk, bounded_velocity"),
    "an attitude that stays somewhere": (GOOD + '[motion.attitude]\nchain = "matern"',
                                         "key motion.attitude:",
                                         "expected tags: 'white_jerk', 'bounded_velocity'"),
    "unknown key of a chain": (GOOD + TIP + "sped_m_s = 1", "key motion.tip: unknown key sped_m_s",
                               "did you mean speed_m_s?"),
    "key of another chain": (GOOD + TIP + "std_mm = 1", "key motion.tip: unknown key std_mm;",
                             "expected one of chain, correlation_time_s, speed_m_s"),
    "wrong unit of a chain": (GOOD + TIP + "speed_furlong_s = 1",
                              "key motion.tip: unknown key speed_furlong_s;",
                              "expected speed_m_s or speed_mm_s"),
    "half a chain": (GOOD + TIP + "speed_m_s = 1", "key motion.tip.correlation_time_s:",
                     "is missing"),
    "unknown part of a motion": (GOOD + "[motion.tips]", "key motion: unknown key tips;",
                                 "expected one of attitude, tip; did you mean tip?"),
    "a motion that is no table": ("motion = 3\n" + GOOD, "key motion:", "valid dictionary"),
    "motion and process noise": (GOOD + "[process_noise]\n[motion]", "process_noise and motion",
                                 "expected motion alone"),
    "unknown process noise": (GOOD + "[process_noise]\njerk = 1", "process_noise: unknown key",
                              "jerk; expected [motion] in its place"),
    "a word for a number": (GOOD + 'rate_hz = "fast"', "sensors.tip.rate_hz:", "valid number"),
}  # fmt: skip


@pytest.mark.filterwarnings(OLD_FILE)
@pytest.mark.parametrize(("text", "key", "expected"), MISTAKES.values(), ids=MISTAKES.keys())
def test_one_sentence_for_a_mistake(text: str, key: str, expected: str, tmp_path: Path) -> None:
    """It names the file, then the key, then what was expected."""
    with pytest.raises(InputError) as error:
        load(tmp_path, text)
    sentence = str(error.value)
    assert sentence.startswith(f"pen file {tmp_path / 'my_pen.toml'}: ")
    assert key in sentence
    assert sentence.index(expected) >= sentence.index(key)
    assert "\n" not in sentence


CONTACT = 'name = "p"\n[sensors.contact]\nkind = "contact"\n'
CAMERA = PEN + 'kind = "pose_camera"\norientation_std_deg = 1\n'
OPEN = {
    "a number in quotes": (GOOD + 'range_g = "4"', "key sensors.tip", "number"),
    "true for a number": (GOOD + "range_g = true", "key sensors.tip", "number"),
    "a preset that is a list": (PEN + 'preset = ["ADXL202"]', "key sensors.tip.preset:",
                                "expected one of ADXL202"),
    "a sensor named like its kind": (CONTACT + "std_m = -1", "key sensors.contact.std_m:",
                                     "greater than 0"),
    "wrong unit of the longer of two names": (CAMERA + "position_std_inch = 1",
                                              "key sensors.tip: unknown key position_std_inch;",
                                              "expected position_std_m or position_std_cm"),
    "no kind": (PEN + "rate_hz = 5", "key sensors.tip.kind:", "expected one of accelerometer"),
}  # fmt: skip
"""What `load_pen` lets pass, or says wrongly, today."""


@pytest.mark.parametrize(("text", "key", "expected"), OPEN.values(), ids=OPEN.keys())
def test_mistakes_without_their_sentence(
    text: str, key: str, expected: str, tmp_path: Path
) -> None:
    test_one_sentence_for_a_mistake(text, key, expected, tmp_path)


def test_file_that_is_not_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "my_pen.toml"
    path.write_bytes('name = "é"'.encode("latin-1"))
    with pytest.raises(InputError, match="expected"):
        load_pen(path)


def test_a_bound_on_one_side(tmp_path: Path) -> None:
    """`StateSpaceModel.bounded` takes an infinity; a pen file cannot say it."""
    model = pen_model(load(tmp_path, GOOD + "[bounds]\ntip_z_m = [0.0, inf]"))
    assert (model.lower[2], model.upper[2]) == (0.0, np.inf)


def test_the_template_of_the_mistakes_is_right(tmp_path: Path) -> None:
    assert load(tmp_path, TURNED + "[[0,-1,0],[1,0,0],[0,0,1]]").sensors["tip"].bandwidth_hz == 50


def test_more_than_one_mistake_is_counted(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is missing \(and 1 more\)$"):
        load(tmp_path, ACCEL)


def test_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(f"pen file {tmp_path}: ")) as error:
        load_pen(tmp_path)
    assert str(error.value).endswith("expected a readable TOML file")


def test_file_that_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "nothing.toml"
    with pytest.raises(InputError, match=re.escape(f"pen file {path} does not exist")) as error:
        load_pen(path)
    assert str(error.value).endswith(
        "expected a file, or a bundled pen: compass, dpoint, reference"
    )


def test_a_pen_is_known_by_name_by_path_and_by_itself() -> None:
    pen = load_pen("dpoint")
    assert load_pen(bundled_pens()["dpoint"]) == pen
    assert as_pen("dpoint") == pen
    assert as_pen(pen) is pen


def test_bound_on_an_unknown_state_is_found_by_the_model(tmp_path: Path) -> None:
    config = load(tmp_path, GOOD + "[bounds]\ntip_z_mm = [0, 1]")
    with pytest.raises(InputError, match="unknown state tip_z_mm; expected one of tip_x_m"):
        pen_model(config)


MOVED = {
    "white jerk": (
        'chain = "white_jerk"\njerk_density_m_s3_per_sqrt_hz = 3',
        TipWhiteJerk(jerk_density_m_s3_per_sqrt_hz=3.0),
    ),
    "white jerk, as it comes": ('chain = "white_jerk"', TipWhiteJerk()),
    "bounded velocity": (
        'chain = "bounded_velocity"\nspeed_mm_s = 80\ncorrelation_time_ms = 100',
        TipBoundedVelocity(speed_m_s=0.08, correlation_time_s=0.1),
    ),
    "Matérn": (
        'chain = "matern"\nstd_cm = 5\ncorrelation_time_s = 0.3\ncentre_cm = [10, 0, -2]',
        TipMatern(std_m=0.05, correlation_time_s=0.3, centre_m=(0.1, 0.0, -0.02)),
    ),
}


@pytest.mark.parametrize("name", MOVED)
def test_a_motion_in_any_unit(name: str, tmp_path: Path) -> None:
    text, expected = MOVED[name]
    tip = load(tmp_path, f"{GOOD}[motion.tip]\n{text}").motion.tip
    assert type(tip) is type(expected)
    for key, value in expected.model_dump().items():
        found = getattr(tip, key)
        assert found == (value if isinstance(value, str) else pytest.approx(value, rel=1e-14))


def test_an_attitude_in_any_unit(tmp_path: Path) -> None:
    chain = 'chain = "bounded_velocity"\nrate_deg_s = 90\ncorrelation_time_s = 0.5'
    attitude = load(tmp_path, f"{GOOD}[motion.attitude]\n{chain}").motion.attitude
    assert isinstance(attitude, AttitudeBoundedRate)
    assert attitude.rate_rad_s == pytest.approx(90 * DEG, rel=1e-14)


def test_a_file_without_a_motion_has_a_hand(tmp_path: Path) -> None:
    assert load(tmp_path, GOOD).motion == Motion()
    alone = load(tmp_path, GOOD + TIP + "speed_m_s = 1\ncorrelation_time_s = 1").motion
    assert alone.attitude == Motion().attitude


OLD = """[process_noise]
tip_jerk_density_m_s3_per_sqrt_hz = 10.0
angle_jerk_density_deg_s3_per_sqrt_hz = 20.0
"""
RENEWED = """[motion.tip]
chain = "white_jerk"
jerk_density_m_s3_per_sqrt_hz = 10.0
[motion.attitude]
chain = "white_jerk"
jerk_density_deg_s3_per_sqrt_hz = 20.0"""


def test_old_process_noise_is_white_jerk_and_says_so(tmp_path: Path) -> None:
    """The warning has the lines to write; written, they are the same pen without a warning."""
    with pytest.warns(FutureWarning) as said:
        old = load(tmp_path, GOOD + OLD)
    (warning,) = said
    first, _, lines = str(warning.message).partition("\n")
    assert first == "[process_noise] is read for the last time in pen-mhe 0.2; write in its place"
    assert lines == RENEWED
    assert old.motion == white_jerk_motion(10.0, 20.0 * DEG)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load(tmp_path, GOOD + lines) == old


@pytest.mark.filterwarnings(OLD_FILE)
def test_half_an_old_process_noise_keeps_its_old_default(tmp_path: Path) -> None:
    old = load(tmp_path, GOOD + OLD[: OLD.index("angle")])
    assert old.motion == white_jerk_motion(10.0, 1000.0)


def test_a_file_of_the_last_release_is_read_as_it_is(data_folder: Path) -> None:
    path = data_folder / "foreign" / "pen_right_mounting.toml"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    with pytest.warns(FutureWarning, match=r"^\[process_noise\] is read for the last time"):
        config = load_pen(path)
    assert config.degrees_of_freedom == 6
    assert config.motion == white_jerk_motion(10.0, 20.0)
    model = pen_model(config, ["accel", "gyro"])
    assert model.state_names[3] == "mrp_x"
    assert np.linalg.eigvalsh(model.prior.covariance).min() > 0
