"""Excel, Parquet and bags of ROS, each written by the format's own library."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.errors import InputError
from tests.recordings.formats.logger_files import DEG, FORCE, RATE, G, T, both, check, read, said

pytest.importorskip("python_calamine")
pytest.importorskip("openpyxl")
pytest.importorskip("rosbags")
N = 200
SHORT = {"time_s": T[:N], "force": FORCE[:N], "rate": RATE[:N]}
HEADER = [
    "Time (s)", "Acc X (g)", "Acc Y (g)", "Acc Z (g)", "Gyro X (°/s)", "Gyro Y (°/s)",
    "Gyro Z (°/s)",
]  # fmt: skip


def frame() -> pd.DataFrame:
    return pd.DataFrame(np.column_stack([T, *both(G, DEG)])[:N], columns=HEADER)


def test_a_workbook(tmp_path: Path) -> None:
    path = tmp_path / "pen.xlsx"
    frame().to_excel(path, index=False, startrow=3)
    check(read(path), **SHORT)
    with pd.ExcelWriter(path) as writer:  # as phyphox writes one
        for name, stem, unit, values in (
            ("Accelerometer", "Acceleration", "m/s^2", FORCE),
            ("Gyroscope", "Gyroscope", "rad/s", RATE),
        ):
            names = ["Time (s)", *(f"{stem} {axis} ({unit})" for axis in "xyz")]
            table = pd.DataFrame(np.column_stack([T, values])[:N], columns=names)
            table.to_excel(writer, sheet_name=name, index=False)
        about = pd.DataFrame({"property": ["version"], "value": ["1.1"]})
        about.to_excel(writer, sheet_name="Metadata Device", index=False)
    assert "columns as phyphox writes them" in said(check(read(path), **SHORT))


def test_a_workbook_that_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pen.xlsx"
    frame().to_excel(path, index=False)
    data = path.read_bytes()
    monkeypatch.setenv("PEN_MHE_MOST_UNPACKED_BYTES", "1000")
    with pytest.raises(InputError, match="unpacked, expected at most 1000"):
        read(path)
    monkeypatch.delenv("PEN_MHE_MOST_UNPACKED_BYTES")
    for damaged in (b"", b"no", data[: len(data) // 2]):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match="cannot be read, expected an Excel workbook"):
            read(path)


def test_parquet_with_dates(tmp_path: Path) -> None:
    path = tmp_path / "pen.parquet"
    dates = pd.Timestamp("2024-05-01") + pd.to_timedelta(T[:N], unit="s")
    frame().drop(columns="Time (s)").assign(when=dates).rename(columns={"when": "time"}).to_parquet(
        path
    )
    assert "times from time, dates" in said(check(read(path), **SHORT))


def write_bag(path: Path, version: int) -> None:
    """Write a bag of ROS 1 or 2 with Imu messages, whose stamps are not those of their arrival."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    stamp = store.types["builtin_interfaces/msg/Time"]
    vector, turn = (store.types[f"geometry_msgs/msg/{one}"] for one in ("Vector3", "Quaternion"))
    imu, head = store.types["sensor_msgs/msg/Imu"], store.types["std_msgs/msg/Header"]
    with Writer1(path) if version == 1 else Writer2(path, version=9) as bag:
        topic = bag.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for k in range(N):
            ns = 1_700_000_000 * 10**9 + round(T[k] * 1e9)
            number = {"seq": k} if version == 1 else {}
            at = stamp(sec=ns // 10**9, nanosec=ns % 10**9)
            header = head(stamp=at, frame_id="imu", **number)
            message = imu(
                header=header,
                orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
                orientation_covariance=np.zeros(9),
                angular_velocity=vector(*RATE[k]),
                angular_velocity_covariance=np.zeros(9),
                linear_acceleration=vector(*FORCE[k]),
                linear_acceleration_covariance=np.zeros(9),
            )
            encode = store.serialize_ros1 if version == 1 else store.serialize_cdr
            bag.write(topic, ns + 5_000_000, encode(message, "sensor_msgs/msg/Imu"))


@pytest.mark.parametrize(("name", "version"), [("pen.bag", 1), ("pen", 2)])
def test_a_bag(tmp_path: Path, name: str, version: int) -> None:
    path = tmp_path / name
    write_bag(path, version)
    assert "columns as ROS writes them" in said(check(read(path), **SHORT))


def test_a_bag_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "pen.bag"
    write_bag(path, 1)
    data = path.read_bytes()
    for damaged in (b"", b"no", data[: len(data) // 2]):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match="cannot be read, expected a bag of ROS"):
            read(path)


def test_dates_of_a_workbook(tmp_path: Path) -> None:
    path = tmp_path / "pen.xlsx"
    start = datetime.datetime(2024, 5, 1)
    dates = [start + datetime.timedelta(seconds=float(t)) for t in T[:N]]
    frame().drop(columns="Time (s)").assign(time=dates).to_excel(path, index=False)
    check(read(path), **SHORT)
