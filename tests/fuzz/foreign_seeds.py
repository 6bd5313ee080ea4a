"""Recordings and truths as other people's programs write them, short."""

from __future__ import annotations

import gzip
import json
from functools import cache

SPLIT = b"\n---8<---\n"
"""Between two files of one input."""


@cache
def foreign() -> tuple[bytes, ...]:
    """Short recordings as other people's loggers write them."""
    lines = [f"{10 * k};{k / 9:.3f};0,1;0,99;{k};-2,5;0" for k in range(6)]
    german = "\n".join(["Zeit [ms];ax [g];ay [g];az [g];gx [°/s];gy [°/s];gz [°/s]", *lines])
    plain = "\n".join(f"{10 * k},{k},20,980,{k},2,3" for k in range(6))
    long = "\n".join(f"{'ACC' if k % 2 else 'GYR'},{10**7 * k},0.1,{k},9.8" for k in range(8))
    dates = "\n".join(f"2024-05-01T12:00:00.{k}Z 0 {k} 9.8 1 2 3" for k in range(6))
    keys = "\n".join(f"t:{10 * k},ax:0.1,ay:0.{k},az:9.8" for k in range(6))
    nine = "\n".join(f"{k / 100},{k},2,9.8,1,2,3,{k},20,-40,{k},5" for k in range(6))
    serial = "\n".join(f"Accel X: 0.1 Y: 0.{k} Z: 9.8 m/s^2 Gyro X: 1 Y: 2 Z: 3" for k in range(6))
    monitor = "\n".join(f"12:00:00.{k}50 -> {k},20,980" for k in range(6))
    return (
        german.encode("utf-16"),
        german.encode("latin-1"),
        f"// Update Rate: 100.0Hz\nmillis,ax,ay,az,gx,gy,gz\n{plain}\n".encode(),
        f"sensor,time,x,y,z\n{long}".encode(),
        f"time ax ay az wx wy wz\n{dates}".encode(),
        keys.encode(),
        f"t,ax,ay,az,gx,gy,gz,Mag X (mG),Mag Y (mG),Mag Z (mG),tip_x_mm,tip_y_mm\n{nine}".encode(),
        serial.encode(),
        monitor.encode(),
        f"时间(ms),加速度X(g),加速度Y(g),加速度Z(g)\n{plain}".encode("gb18030"),
        json_lines(),
        gzip.compress(plain.encode()),
    )


def json_lines() -> bytes:
    rows = [
        {"ts": 10 * k, "acc": [0.1, k / 9, 9.8], "gyr": {"x": k, "y": 0, "z": 1}} for k in range(6)
    ]
    return "\n".join(map(json.dumps, rows)).encode()


def _motive() -> str:
    """OptiTrack's export of a rigid body."""
    rows = "\n".join(f"{k},{k / 100},0,0,0,1,{k / 9:.3f},0.1,0.2,0" for k in range(6))
    names = ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error"
    ids = f",ID,{','.join(['1'] * 8)}\n{names}\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z,"
    return f"Format Version,1.23,Export Frame Rate,100.0,Length Units,Meters\n\n{ids}\n{rows}\n"


def truths() -> tuple[bytes, ...]:
    """Motion capture, tablets and angles."""
    tum = "\n".join(f"{1.3e9 + k / 100:.2f} 0.{k} 0.2 0.3 0 0 0 1" for k in range(6))
    tablet = "\n".join(f"{10 * k},{k},{2 * k},{k % 2},130,55" for k in range(6))
    vicon = "\n".join(f"{k},0,{k}.5,2,3,{k},5,6" for k in range(6))
    return (
        _motive().encode(),
        f"# timestamp tx ty tz qx qy qz qw\n{tum}\n".encode(),
        f"Timestamp (ms),X,Y,Pressure,Azimuth,Altitude\n{tablet}\n".encode(),
        "Trajectories\n100\n,,pen:tip,,,pen:top,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n"
        f",,mm,mm,mm,mm,mm,mm\n{vicon}\n".encode(),
        f"time_s,azimuth_deg,elevation_deg,spin_deg\n{tablet}".encode(),
    )


def merged() -> bytes:
    """Two files of one recording, each at its own rate."""
    rates = ((100, "Acceleration x (m/s^2)"), (50, "Gyroscope x (rad/s)"))
    texts = []
    for rate, name in rates:
        header = ",".join(name.replace(" x ", f" {axis} ") for axis in "xyz")
        rows = "\n".join(f"{k / rate},{k},2,9.8" for k in range(6))
        texts.append(f"Time (s),{header}\n{rows}\n".encode())
    return SPLIT.join(texts)


NINE_AXES = b"""
[sensors.mag]
kind = "magnetometer"
field_strength_ut = 48.0
field_dip_deg = 64.0
noise_std_ut = 0.4
[sensors.tablet]
kind = "tip_position"
axes = ["x", "y"]
std_mm = 0.1
delay_ms = 8.0
[recording]
columns = { accel = ["ax", "-ay", "az"], time = "millis" }
units = { gyro = "deg_s", time = "ms" }
"""
"""What a pen file may have besides."""
