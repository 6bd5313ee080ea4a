"""Loggers by their headers, as their public descriptions have them: each file is written here."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.arrays import Array
from models.errors import InputError
from tests.recordings.formats.logger_files import (
    DEG,
    FORCE,
    PEN,
    RATE,
    G,
    T,
    both,
    check,
    millis,
    read,
    rows,
    said,
    whole,
)

NS = np.round(T * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
XSENS = "// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Filter Profile: human (46.1)\n"
DOWN = -FORCE / G
"""What Apple's accelerometers read, g."""
STILL, MOVED = 0.9 * DOWN, 0.1 * DOWN


def xyz(stem: str, unit: str = "", sep: str = ",") -> str:
    return sep.join(f"{stem}{axis}{unit}" for axis in "XYZ")


SENSORLOG = (
    "loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),"
    f"{xyz('accelerometerAcceleration', '(G)')},motionTimestamp_sinceReboot(s),"
    f"{xyz('motionRotationRate', '(rad/s)')},{xyz('motionUserAcceleration', '(G)')},"
    f"{xyz('motionGravity', '(G)')},gyroTimestamp_sinceReboot(s),{xyz('gyroRotation', '(rad/s)')}"
)


def sensorlog() -> str:
    dates = pd.Timestamp("2024-05-01") + pd.to_timedelta(T, unit="s")
    numbers = rows(
        [np.arange(len(T)), T + 5000, *DOWN.T, T + 5000, *RATE.T, *MOVED.T, *STILL.T,
         T + 5000, *RATE.T]
    )  # fmt: skip
    lines = (f"{d} +0200,{line}" for d, line in zip(dates, numbers.splitlines(), strict=True))
    return "\n".join([SENSORLOG, *lines])


def androsensor() -> str:
    stems = ("ACCELEROMETER", "GRAVITY", "LINEAR ACCELERATION")
    names = [f"{stem} {axis} (m/s²)" for stem in stems for axis in "XYZ"]
    names += [f"GYROSCOPE {axis} (rad/s)" for axis in "XYZ"]
    grav = 0.97 * FORCE
    columns = [*FORCE.T, *grav.T, *(FORCE - grav).T, *RATE.T, 0 * T + 12, millis()]
    return rows(columns, ";".join([*names, "LIGHT (lux)", "Time since start in ms "]), sep=";")


def long_rows(accel: object, gyro: object, offset: int = 0) -> list[str]:
    found = []
    for t, f, w in zip(NS - offset, FORCE, RATE, strict=True):
        found.append(f"{accel},{t},{f[0]:.6f},{f[1]:.6f},{f[2]:.6f}")
        found.append(f"{gyro},{t + 2_000_000},{w[0]:.6f},{w[1]:.6f},{w[2]:.6f}")
    return found


TEXTS: dict[str, tuple[Callable[[], str], str]] = {
    "mg.csv": (
        lambda: rows([millis(5321), *both(G / 1000, DEG)], "millis,ax,ay,az,gx,gy,gz", end="\r\n"),
        "accel from ax, ay, az in mg (the median of its norm",
    ),
    "micros.csv": (
        lambda: rows([(np.round(T * 1e6).astype(np.int64) + 2**32 - 3_000_000) % 2**32, *both()],
                     "micros,ax,ay,az,gx,gy,gz"),
        "1 overflow of micros at 4294967296 undone",
    ),
    "counts.csv": (
        lambda: rows(whole([millis(), *both(G / 16384, DEG / 131)]), "millis,ax,ay,az,gx,gy,gz"),
        "gyro from gx, gy, gz in counts of 1/131 deg/s",
    ),
    "xsens.txt": (
        lambda: XSENS + rows([np.arange(len(T)) + 65000, whole([T * 1e4])[0], *both(), *FORCE.T],
                             f"PacketCounter\tSampleTimeFine\t{xyz('Acc_', sep=chr(9))}\t"
                             f"{xyz('Gyr_', sep=chr(9))}\t{xyz('Mag_', sep=chr(9))}", sep="\t"),
        "times from SampleTimeFine, in 100us",
    ),
    "xsens_counter.txt": (
        lambda: XSENS + rows([(np.arange(len(T)) + 65000) % 65536, *both()],
                             f"PacketCounter\t{xyz('Acc_', sep=chr(9))}\t{xyz('Gyr_', sep=chr(9))}",
                             sep="\t"),
        "times from PacketCounter at the 100 Hz that stand above the header",
    ),
    "dot.csv": (
        lambda: "DeviceTag:,DOT\nOutputRate:,100Hz\n\n"
        + rows([np.arange(len(T)), whole([T * 1e6 + 9e8])[0], *both(1.0, DEG)],
               f"PacketCounter,SampleTimeFine,{xyz('Acc_')},{xyz('Gyr_')}"),
        "times from SampleTimeFine, in us",
    ),
    "rostopic.csv": (
        lambda: rows([NS + 7_000_000 * (np.arange(len(T)) % 2), NS, *RATE.T, *FORCE.T],
                     "%time,field.header.stamp," + ",".join(
                         f"field.{v}.{a}" for v in ("angular_velocity", "linear_acceleration")
                         for a in "xyz")),
        "times from field.header.stamp, in ns",
    ),
    "ros2.csv": (
        lambda: rows([NS // 10**9, NS % 10**9, *RATE.T, *FORCE.T],
                     "header.stamp.sec,header.stamp.nanosec," + ",".join(
                         f"{v}.{a}" for v in ("angular_velocity", "linear_acceleration")
                         for a in "xyz")),
        "times from header.stamp.sec and header.stamp.nanosec, in ns",
    ),
    "sensorlog.csv": (sensorlog, "sign turned: it reads downward at rest"),
    "coremotion.csv": (
        lambda: rows([T + 700, *MOVED.T, *STILL.T, *RATE.T], "timestamp," + ",".join(
            f"{v}.{a}" for v in ("userAcceleration", "gravity", "rotationRate") for a in "xyz")),
        "userAcceleration.z plus gravity.x, gravity.y, gravity.z in g",
    ),
    "androsensor.csv": (androsensor, "times from Time since start in ms, in ms"),
    "px4.csv": (
        lambda: rows([whole([T * 1e6 + 5e8])[0], *RATE.T, *FORCE.T], "timestamp," + ",".join(
            f"{v}[{k}]" for v in ("gyro_rad", "accelerometer_m_s2") for k in range(3))),
        "columns as PX4 writes them",
    ),
    "ardupilot.csv": (
        lambda: rows([whole([T * 1e6])[0], *RATE.T, *FORCE.T], f"TimeUS,{xyz('Gyr')},{xyz('Acc')}"),
        "columns as ArduPilot writes them",
    ),
    "st.csv": (
        lambda: rows([millis(), *both(G / 1000, DEG / 1000)],
                     f"T [ms],{xyz('LSM6DSO_ACC_', ' [mg]')},{xyz('LSM6DSO_GYRO_', ' [mdps]')}"),
        "in mdeg_s",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_a_logger(tmp_path: Path, name: str) -> None:
    write, sentence = TEXTS[name]
    (tmp_path / name).write_text(write(), encoding="utf-8")
    assert sentence in said(check(read(tmp_path / name)))


LONG: dict[str, Callable[[], str]] = {
    "words.csv": lambda: "\n".join(
        ["sensor,timestamp,x,y,z",
         *long_rows("android.sensor.accelerometer", "android.sensor.gyroscope")]),
    "types.csv": lambda: "\n".join(["sensor_type,timestamp_ns,v0,v1,v2", *long_rows(1, 4)]),
    "none.txt": lambda: "\n".join(long_rows("ACC", "GYR", 1_699_900_000_000_000_000)),
    "gnss.txt": lambda: "\n".join(
        [f"# UncalAccel,elapsedRealtimeNanos,{xyz('UncalAccel', 'Mps2')}",
         f"# UncalGyro,elapsedRealtimeNanos,{xyz('UncalGyro', 'RadPerSec')}",
         *long_rows("UncalAccel", "UncalGyro", 1_699_900_000_000_000_000)]),
}  # fmt: skip


@pytest.mark.parametrize("name", LONG)
def test_a_row_for_each_reading_of_any_sensor(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(LONG[name]())
    found = check(read(tmp_path / name)).recording
    np.testing.assert_allclose(found.sensor("gyro")[0] - found.sensor("accel")[0], 0.002, atol=1e-6)


def test_one_sample_of_each_sensor_stays_where_it_is(tmp_path: Path) -> None:
    late = T[::2] + 0.0031
    (tmp_path / "phyphox_Accelerometer.csv").write_text(
        rows([T, *FORCE.T], ",".join(f'"Acceleration {a} (m/s^2)"' for a in "txyz").replace(
            '"Acceleration t (m/s^2)"', '"Time (s)"')))  # fmt: skip
    (tmp_path / "phyphox_Gyroscope.csv").write_text(
        rows([late, *RATE[::2].T],
             '"Time (s)",' + ",".join(f'"Gyroscope {a} (rad/s)"' for a in "xyz"))
    )  # fmt: skip
    paths = [tmp_path / f"phyphox_{name}.csv" for name in ("Accelerometer", "Gyroscope")]
    for path in (paths, tmp_path):
        found = read(path).recording
        np.testing.assert_array_equal(found.sensor("accel")[0], T)
        np.testing.assert_allclose(found.sensor("gyro")[0], late, rtol=0, atol=1e-9)
        np.testing.assert_allclose(found.sensor("gyro")[1], RATE[::2], atol=1e-6)
    paths[1].write_text(paths[1].read_text().replace("\n", "\n9", 1))
    text = rows([late + 500, *RATE[::2].T], '"Time (s)",' + ",".join(f"gyro {a}" for a in "xyz"))
    paths[1].write_text(text)
    with pytest.raises(InputError, match="when nothing else was, expected files of one recording"):
        read(paths)


def sensor_logger(values: Array) -> str:
    return rows([NS, T + 0.25, *values.T[::-1]], "time,seconds_elapsed,z,y,x")


def test_sensor_logger_as_an_archive(tmp_path: Path) -> None:
    """Its Accelerometer has no gravity; its columns are z, y, x."""
    grav = 0.97 * FORCE
    files = {
        "Accelerometer.csv": sensor_logger(FORCE - grav),
        "Gravity.csv": sensor_logger(grav),
        "Gyroscope.csv": sensor_logger(RATE),
        "TotalAcceleration.csv": sensor_logger(FORCE),
        "AccelerometerUncalibrated.csv": sensor_logger(FORCE + 1),
        "Metadata.csv": "version,device name\n3,Pixel 6\n",
        "../../escape.csv": "time,x\n0,1\n1,2\n",
    }
    with zipfile.ZipFile(tmp_path / "log.zip", "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    sentences = said(check(read(tmp_path / "log.zip")))
    assert "columns as Sensor Logger writes them" in sentences
    assert "Metadata.csv: nothing of it is needed, ignored" in sentences
    assert not (tmp_path.parent.parent / "escape.csv").exists()


def test_without_gravity_is_a_finding(tmp_path: Path) -> None:
    (tmp_path / "Accelerometer.csv").write_text(sensor_logger(FORCE - FORCE.mean(axis=0) * 0.99))
    (tmp_path / "Gyroscope.csv").write_text(sensor_logger(RATE))
    (finding,) = read(tmp_path).findings
    assert "there is no gravity in it" in finding.sentence()


def test_a_pose_of_position_and_quaternion(tmp_path: Path) -> None:
    turn = np.column_stack([0 * T, 0 * T, np.sin(T / 20), np.cos(T / 20)])
    path = tmp_path / "pen.csv"
    columns = [millis(), *both(), 0 * T + 100, 0 * T + 200, 0 * T - 30, *turn.T]
    path.write_text(rows(columns, "millis,ax,ay,az,gx,gy,gz,px_mm,py_mm,pz_mm,qx,qy,qz,qw"))
    poses = read(path).recording.readings["camera"]
    np.testing.assert_allclose(poses[:, :5], [[0.1, 0.2, -0.03, 0, 0]] * len(T), atol=1e-6)
    np.testing.assert_allclose(poses[:, 5], T / 10, atol=1e-5)
    path.write_text(rows(columns, "millis,ax,ay,az,gx,gy,gz,a1,a2,a3,b1,b2,b3,b4"))
    again = read(path, columns="camera=a1,a2,a3,b1,b2,b3,b4", units={"camera": "mm"})
    np.testing.assert_array_equal(again.recording.readings["camera"], poses)
    # A quaternion alone is what a phone thinks of its attitude.
    path.write_text(rows([millis(), *both(), *turn.T], "millis,ax,ay,az,gx,gy,gz,qx,qy,qz,qw"))
    assert "not needed, ignored: qx, qy, qz, qw" in said(read(path))


def test_two_sensors_of_a_kind(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    header = "millis,ax1,ay1,az1,gx1,gy1,gz1,ax2,ay2,az2"
    path.write_text(rows([millis(), *both(), *(FORCE + 1).T], header))
    assert "ax2, ay2, az2 not used (--columns accel=…" in said(check(read(path)))
    found = read(path, columns="accel_lower=ax1,ay1,az1;accel_upper=ax2,ay2,az2").recording
    assert list(found.readings) == ["gyro", "accel_lower", "accel_upper"]
    header = "millis,lower ax,lower ay,lower az,gx1,gy1,gz1,upper ax,upper ay,upper az"
    path.write_text(rows([millis(), *both(), *(FORCE + 1).T], header))
    found = read(path).recording
    assert {"accel_lower", "accel_upper"} <= set(found.readings)
    np.testing.assert_allclose(found.readings["accel_upper"], FORCE + 1, atol=1e-5)


def test_the_pens_file_names_the_columns(tmp_path: Path) -> None:
    from models.pen_file import parse_pen
    from recordings.read import read_written

    data = {**PEN.model_dump(), "recording": {
        "columns": {"accel": ["p1", "p2", "p3"], "gyro": "r1, r2,r3", "time": "when"},
        "units": {"accel": "g/4096", "time": "ms"},
    }}  # fmt: skip
    pen = parse_pen(data)
    path = tmp_path / "pen.csv"
    columns = [whole([T * 1e3])[0], *both(G / 4096)]
    path.write_text(rows(columns, "when,p1,p2,p3,r1,r2,r3"))
    check(read_written(path, pen))
    with pytest.raises(
        InputError, match=r"no column p33 for accel, expected one of .* did you mean p3"
    ):
        read_written(path, pen, columns="accel=p1,p2,p33")
    # A recording whose columns are called otherwise is read as any.
    path.write_text(rows([millis(), *both()], "millis,ax,ay,az,gx,gy,gz"))
    assert read_written(path, pen, units={"accel": "m_s2"}).recording.readings.keys() == {
        "accel", "gyro"
    }  # fmt: skip
