"""Bags of ROS 1 (.bag) and ROS 2 (a folder with metadata.yaml, .db3, .mcap), a table a topic.

Read by `rosbags <https://pypi.org/project/rosbags>`_, an extra. Of the messages
(docs.ros.org, sensor_msgs and geometry_msgs) these are read: Imu, MagneticField, PoseStamped,
TransformStamped and PoseWithCovarianceStamped, by the stamps in their headers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from models.errors import InputError
from models.limits import check_most
from recordings.foreign.source_table import SourceTable

METADATA = "metadata.yaml"
BAG_SUFFIXES = (".bag", ".db3", ".mcap")
EXPECTED = "a bag of ROS with sensor_msgs/Imu messages"


def is_bag(path: Path) -> bool:
    """Whether a path is a bag: a file, or a folder of ROS 2."""
    if path.is_dir():
        return (path / METADATA).is_file()
    return path.suffix in BAG_SUFFIXES


def read_ros_bag(
    path: Path, where: str, *, header: Sequence[str] | None = None
) -> list[SourceTable]:
    """Read the topics of a bag.

    Raises
    ------
    InputError
        If it cannot be read, has no such messages, is larger than `models.limits.LIMITS` allows,
        or the reader of bags is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{where}: reading it needs rosbags, expected pip install 'pen-mhe[ros]'"
        ) from None
    files = [path] if path.is_file() else [one for one in path.iterdir() if one.is_file()]
    check_most("table_bytes", sum(one.stat().st_size for one in files), where)
    found = []
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            for connection in bag.connections:
                columns = MESSAGES.get(connection.msgtype)
                if columns is None:
                    continue
                check_most("rows", connection.msgcount, where)
                rows = [
                    columns(bag.deserialize(data, connection.msgtype))
                    for _, _, data in bag.messages(connections=[connection])
                ]
                found.append(SourceTable(connection.topic, pd.DataFrame(rows)))
    except InputError:
        raise
    except Exception as error:  # whatever a damaged bag makes of itself
        raise InputError(f"{where}: cannot be read, expected {EXPECTED}") from error
    if not found:
        raise InputError(f"{where}: no topic of {', '.join(MESSAGES)}, expected {EXPECTED}")
    return found


def _stamp(message: Any) -> dict[str, float]:
    stamp = message.header.stamp
    return {"time [ns]": stamp.sec * 10**9 + stamp.nanosec}


def _imu(message: Any) -> dict[str, float]:
    return {
        **_stamp(message),
        **_vector("linear_acceleration", message.linear_acceleration, "m/s2"),
        **_vector("angular_velocity", message.angular_velocity, "rad/s"),
    }


def _magnetic(message: Any) -> dict[str, float]:
    return {**_stamp(message), **_vector("magnetic_field", message.magnetic_field, "T")}


def _pose(message: Any, place: Any, turn: Any) -> dict[str, float]:
    quaternion = {f"orientation.{axis}": getattr(turn, axis) for axis in "xyzw"}
    return {**_stamp(message), **_vector("position", place, "m"), **quaternion}


def _vector(name: str, vector: Any, unit: str) -> dict[str, float]:
    return {f"{name}.{axis} [{unit}]": getattr(vector, axis) for axis in "xyz"}


MESSAGES: Mapping[str, Callable[[Any], dict[str, float]]] = MappingProxyType(
    {
        "sensor_msgs/msg/Imu": _imu,
        "sensor_msgs/msg/MagneticField": _magnetic,
        "geometry_msgs/msg/PoseStamped": lambda m: _pose(m, m.pose.position, m.pose.orientation),
        "geometry_msgs/msg/PoseWithCovarianceStamped": lambda m: _pose(
            m, m.pose.pose.position, m.pose.pose.orientation
        ),
        "geometry_msgs/msg/TransformStamped": lambda m: _pose(
            m, m.transform.translation, m.transform.rotation
        ),
    }
)
"""Type of a message → its columns."""
