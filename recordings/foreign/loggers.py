"""Loggers by their headers: what each writes where its headers say nothing of it.

A row is a public description of what a program writes; what the data say against it counts more.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from recordings.foreign.column_names import (
    ACCELEROMETER,
    GRAVITY,
    GYROSCOPE,
    LINEAR,
    MAGNETOMETER,
)
from recordings.foreign.source_table import SourceTable

_SI: Mapping[str, str] = {
    ACCELEROMETER: "m_s2", LINEAR: "m_s2", GRAVITY: "m_s2", GYROSCOPE: "rad_s", MAGNETOMETER: "ut"
}  # fmt: skip
_APPLE: Mapping[str, str] = {
    ACCELEROMETER: "g", LINEAR: "g", GRAVITY: "g", GYROSCOPE: "rad_s", MAGNETOMETER: "ut"
}  # fmt: skip


@dataclass(frozen=True)
class Logger:
    """A program that writes recordings.

    Parameters
    ----------
    name : for people
    headers : what its headers, joined by bars, match
    units : kind → unit of its readings where their headers have none
    force_sign : -1 where an accelerometer at rest reads downward
    normalised : kinds of which the Earth's own is 1
    source : where that is written
    about : what stands in the file beside its tables, see `SourceTable`
    """

    name: str
    headers: str
    units: Mapping[str, str] = field(default_factory=dict)
    force_sign: float = 1.0
    source: str = ""
    normalised: tuple[str, ...] = ()
    about: str = ""


LOGGERS: tuple[Logger, ...] = (
    Logger(
        "SensorLog for iOS", r"loggingTime\(|accelerometerAccelerationX|motionUserAccelerationX",
        _APPLE, -1.0, "sensorlog.berndthomas.net; signs: Apple's CMAccelerometerData",
    ),
    Logger(
        "Apple's CoreMotion", r"userAcceleration\W?x|rotationRate\W?x", _APPLE, -1.0,
        "developer.apple.com/documentation/coremotion: total = gravity + userAcceleration, g",
    ),
    Logger(
        "DeviceMotionEvent of a browser", r"rotationRate\W?alpha",
        {**_SI, GYROSCOPE: "deg_s"}, 1.0, "w3.org/TR/orientation-event: m/s2, deg/s",
    ),
    Logger(
        "Sensor Logger on an Apple Watch", r"seconds_elapsed.*gravityX.*accelerationX",
        _APPLE, -1.0,
        "awesome-sensor-logger/CROSSPLATFORM.md: signs as CoreMotion's; its g of motion",
    ),
    Logger(
        "Sensor Logger on an iPhone", r"seconds_elapsed", _SI, -1.0,
        "awesome-sensor-logger/CROSSPLATFORM.md: but for standardised files",
        about=r"platform=ios(?!.*standardisation=true)",
    ),
    Logger(
        "Sensor Logger", r"seconds_elapsed", _SI, 1.0,
        "github.com/tszheichoi/awesome-sensor-logger: time in ns, Accelerometer without gravity",
    ),
    Logger("GNSSLogger for Android", r"Uncal(Accel|Gyro)[XYZ]", _SI, 1.0, "android/SensorEvent"),
    Logger(
        "Xsens MT Manager", r"PacketCounter|SampleTimeFine", {ACCELEROMETER: "m_s2"}, 1.0,
        "MT Manager User Manual: Acc m/s2, Gyr rad/s, Mag a.u.; Movella DOT: Gyr deg/s",
        normalised=(MAGNETOMETER,),
    ),
    Logger(
        "ROS", r"linear_acceleration|angular_velocity",
        {LINEAR: "m_s2", ACCELEROMETER: "m_s2", GYROSCOPE: "rad_s", MAGNETOMETER: "t"}, 1.0,
        "sensor_msgs/Imu: m/s2 with gravity, rad/s; sensor_msgs/MagneticField: T",
    ),
    Logger("ArduPilot", r"TimeUS.*(AccX|GyrX)|(AccX|GyrX).*TimeUS", _SI, 1.0, "log message IMU"),
    Logger("PX4", r"accelerometer_m_s2\[0\]|gyro_rad\[0\]", _SI, 1.0, "sensor_combined.msg"),
    Logger("phyphox", r"Time \(s\).*(Acceleration|Gyroscope) [xX]", {}, 1.0, "phyphox.org"),
    Logger("an Arduino sketch", r"(^|\|)\W*(millis|micros)\b", {}),
)  # fmt: skip


def logger_of(tables: Sequence[SourceTable]) -> Logger | None:
    """Return the logger that wrote tables; None where no row of `LOGGERS` knows their headers."""
    headers = "|".join(str(header) for table in tables for header in table.frame.columns)
    about = tables[0].about if tables else ""
    return next(
        (row for row in LOGGERS if re.search(row.headers, headers) and re.search(row.about, about)),
        None,
    )
