"""Recordings and truths as other people's programs write them, short."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
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
        *_of_lines(),
    )


def _of_lines() -> Iterator[bytes]:
    """Yield lines with a form of their own, and rows of one number."""
    numbers = [(10 * k, f"{s}{a}", k) for k in range(6) for s in "ag" for a in "xyz"]
    yield "".join(f">{name}:{t}:{value}§g|n\n" for t, name, value in numbers).encode()
    yield ("t,name,value\n" + "".join(f"{t},{n},{v}\n" for t, n, v in numbers)).encode()
    yield "".join(
        f"stamp:\n  sec: {k}\n  nanosec: 5\nacceleration:\n  x: {k}.5\n  y: 1\n  z: 9\n---\n"
        for k in range(6)
    ).encode()
    yield "".join(f"imu,of=pen ax={k}.1,ay=0,az=9.8 17{k:017d}\n" for k in range(6)).encode()
    yield "".join(f"12:00:0{k} -> $VNMAR,1,2,3,0,{k},9.8,0.1,{k},0*5A\n" for k in range(6)).encode()
    yield ("1793714709,1793714709,1793714709\n32,32,32\n" + "1,2,63\n" * 6).encode()
    yield "".join(f"33,{10 * k},0.1,{k},9.8;\n" for k in range(6)).encode()
    yield ("imu_id,t,ax,ay,az\n" + "".join(f"{k % 2},{k},0,{k},-999\n" for k in range(44))).encode()
    yield "".join(f"{10 * k},{k % 7},0,9.8,{k % 5},1,2\n" for k in range(110)).encode()


def json_lines() -> bytes:
    rows = [
        {"ts": 10 * k, "acc": [0.1, k / 9, 9.8], "gyr": {"x": k, "y": 0, "z": 1}} for k in range(6)
    ]
    return "\n".join(map(json.dumps, rows)).encode()


def json_shapes() -> tuple[bytes, ...]:
    """JSON of other shapes: of packets, columns, rows beside their names, a sensor each."""
    vectors = [{"x": 0.1, "y": k, "z": 9.8} for k in range(6)]
    rows = [[0.1, k, 9.8] for k in range(6)]
    named = {"sensors": [{"name": f"acc{a}", "units": "m/s2"} for a in "XYZ"], "values": rows}
    packets = [{"IMU6": {"Timestamp": k, "ArrayAcc": vectors, "ArrayGyro": rows}} for k in range(3)]
    shapes = (
        {"payload": {"interval_ms": 10, **named}},
        {"fs": 100, "acc": rows, "gyro": {a: list(range(6)) for a in "xyz"}},
        {"accelerometer": vectors, "gyroscope": vectors, "t": list(range(6))},
        [{"topic": "pen", "payload": json.dumps({"t": k, "acc": rows[k]})} for k in range(6)],
        packets,
        rows,
    )
    printed = "\n".join(str({"t": k, "acc": row}) for k, row in enumerate(rows)).encode()
    return (*(json.dumps(shape).encode() for shape in shapes), printed)


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
