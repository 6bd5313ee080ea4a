"""Customs of loggers beyond the first ones: spellings, rules, JSON, serial monitors, other scripts.

Each line of a table was misread or refused once.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.errors import InputError
from recordings.foreign.column_names import kind_named, meaning
from recordings.foreign.header_units import split_header
from recordings.foreign.sniffing import is_number
from recordings.formats.line_forms import line_form
from tests.recordings.formats.logger_files import (
    DEG,
    FORCE,
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

NAMES = "ax,ay,az,gx,gy,gz"
HEADER = f"millis,{NAMES}"
PLAIN = rows([millis(), *both()], HEADER)
STAMPS = pd.Timestamp("2024-05-01 12:00:00") + pd.to_timedelta(T, unit="s")
CLOCK = [stamp.strftime("%H:%M:%S.%f")[:-3] for stamp in STAMPS]
NS = np.round(T * 1e9).astype(np.int64) + 1_700_000_000_000_000_000


def printed(form: str, force: float = 1.0, rate: float = 1.0) -> str:
    """Return a line for each sample, with t and a and w of it in a format."""
    values = zip(millis(), FORCE / force, RATE / rate, CLOCK, strict=True)
    return "".join(form.format(t=t, a=a, w=w, clock=clock) + "\n" for t, a, w, clock in values)


def fortran(x: float) -> str:
    return f"{x:.6E}".replace("E", "D")


def thousands(x: float, mark: str) -> str:
    return f"{x:,.2f}".replace(",", mark)


def spelt(spell: Callable[[float], str], header: str, sep: str, scale: float = 1.0) -> str:
    columns = [1000 * T + 1000, *both(1 / scale, 1 / scale)]
    cells = zip(*columns, strict=True)
    return "\n".join([header.replace(",", sep), *(sep.join(map(spell, row)) for row in cells)])


def of_json(as_row: Callable[[int], object]) -> list[object]:
    return [as_row(k) for k in range(len(T))]


ZH = ",".join(f"{kind}{axis}({unit})" for kind, unit in (("加速度", "g"), ("角速度", "°/s"))
              for axis in "XYZ")  # fmt: skip
MILLIG = ",".join(f"a{axis} (mg)" for axis in "xyz")
MDPS = ",".join(f"g{axis} (mdps)" for axis in "xyz")

TEXTS: dict[str, Callable[[], str | bytes]] = {
    "fortran.csv": lambda: spelt(fortran, HEADER, " "),
    "thousands.csv": lambda: spelt(
        lambda x: f'"{thousands(x, ",")}"', f"time (ms),{MILLIG},{MDPS}", ",", 1e3
    ).replace("(mg)", "(mm/s2)").replace("(mdps)", "(mrad/s)"),
    "swiss.csv": lambda: spelt(
        lambda x: thousands(x, "'"), f"time (ms),{MILLIG},{MDPS}", ";", 1e3
    ).replace("(mg)", "(mm/s2)").replace("(mdps)", "(mrad/s)"),
    "minus.txt": lambda: PLAIN.replace("-", "\N{MINUS SIGN}"),
    "ruled.txt": lambda: PLAIN.replace(HEADER, f"{HEADER}\n{'-' * 60}").replace(",", " "),
    "shimmer.csv": lambda: rows(
        [1.6e12 + 1e3 * T, *FORCE.T, *(RATE / DEG).T, *FORCE.T],
        '"sep=\t"\n' + "\t".join(
            ["Shimmer_DA8A_Timestamp_Unix_CAL"] + [f"Shimmer_DA8A_{s}_{a}_CAL" for s in
             ("Accel_LN", "Gyro", "Mag") for a in "XYZ"])
        + "\nms\t" + "\t".join(["m/(s^2)"] * 3 + ["deg/s"] * 3 + ["local_flux"] * 3), sep="\t"),
    "witmotion.csv": lambda: "\n".join([
        f"时间,设备名称,片上时间(),{ZH}", *(
            f"{stamp.strftime('%Y-%m-%d %H:%M:%S.%f')[:-3]},WT901BLE67(d8:2e:1f),"
            f"{stamp.strftime('%Y-%m-%d %H:%M:%S:%f')[:-3]},{line}" for stamp, line in
            zip(STAMPS, rows(both(G, DEG)).splitlines(), strict=True))]),
    "witmotion.txt": lambda: "\n".join([
        "StartTime: 2024-05-01 12:00:00.000",
        "address\tTime(s)\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tT(°)", *(
            f"0x50\t{stamp.strftime('%Y-%m-%d %H:%M:%S.%f')[:-3]}\t{line}\t28.4" for stamp, line in
            zip(STAMPS, rows(both(G, DEG), sep="\t").splitlines(), strict=True))]),
    "vicon.csv": lambda: rows(
        [np.arange(len(T)) // 5, np.arange(len(T)) % 5, *both(1.0, DEG)],
        "Devices\n100\n,,IMU - Accel,,,IMU - Gyro,,\n"
        "Frame,Sub Frame,Acc X,Acc Y,Acc Z,Gyro X,Gyro Y,Gyro Z\n"
        ",,m/s²,m/s²,m/s²,deg/s,deg/s,deg/s"),
    "gbk.txt": lambda: rows([T, *both(G, DEG)], f"时间(s),{ZH}").encode("gbk"),
    "sjis.csv": lambda: rows([T, *both(G, DEG)], f"時刻[s],{ZH}").encode("shift_jis"),
    "colons.csv": lambda: "\n".join([
        f"time,{NAMES}", *(f"{clock[:8]}:{clock[9:]},{line}" for clock, line in
                           zip(CLOCK, rows(both()).splitlines(), strict=True))]),
    "matlab.csv": lambda: "\n".join([
        "Time,Acceleration_1,Acceleration_2,Acceleration_3,"
        "AngularVelocity_1,AngularVelocity_2,AngularVelocity_3",
        *(f"{t:g} sec,{line}" for t, line in zip(T, rows(both()).splitlines(), strict=True))]),
    "physics.csv": lambda: rows([T, *both(G)], "time,gFx,gFy,gFz,wx,wy,wz"),
    "axivity.csv": lambda: rows(
        [T, *both(G, DEG)],
        "Time," + ",".join(f"{s}-{a} ({u})" for s, u in (("Accel", "g"), ("Gyro", "d/s"))
                           for a in "XYZ")),
    "aircraft.csv": lambda: rows(
        [T, *both(1.0, DEG)], "Time [s],ax,ay,az,Roll rate [deg/s],Pitch rate [deg/s],"
        "Yaw rate [deg/s]"),
    "phidgets.csv": lambda: rows(
        [millis(), *both(G, DEG)], "Timestamp(ms)," + ",".join(
            f"{s}[{k}]({u})" for s, u in (("Acceleration", "g"), ("AngularRate", "°/s"))
            for k in range(3))),
    "iio.csv": lambda: rows(
        [NS, *both()], "in_timestamp," + ",".join(
            f"in_{s}_{a}_raw" for s in ("accel", "anglvel") for a in "xyz")),
    "spanish.csv": lambda: rows(
        [T, *both(1.0, DEG)], "Hora [s];" + ";".join(
            f"{s} {a} ({u})" for s, u in (("Aceleración", "m/s²"), ("Velocidad angular", "°/s"))
            for a in "XYZ"), sep=";"),
    "node.csv": lambda: "\n".join([
        "HostTimestamp,NodeName,RawData,ax,ay,az,gx,gy,gz",
        *(f"{t},tile @ C0:85,0A1B2C,{line}" for t, line in
          zip(millis(), rows(both()).splitlines(), strict=True))]),
    "labview.txt": lambda: rows(
        [T, *both()], "LabVIEW Measurement\t\nOperator\tme\n" + "".join(
            f"{key}\t" + "\t".join([value] * 6) + "\n" for key, value in
            (("Samples", "800"), ("Date", "2023/05/02"), ("Time", "10:11:12.1"), ("Unit", "g")))
        + "time\tax\tay\taz\tgx\tgy\tgz\tComment", sep="\t"),
    "ts.csv": lambda: PLAIN.replace("millis", "ts"),
    "free.txt": lambda: "// Update Rate: 100.0Hz\n" + rows(
        [np.arange(len(T)), *(FORCE * 0.9 + 0.1).T, *both()],
        "PacketCounter,FreeAcc_X,FreeAcc_Y,FreeAcc_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"),
    "missing.csv": lambda: "\n".join(
        line if k % 9 != 4 else f"{line.split(',')[0]},n.a.,n.a.,n.a.,---,---,---"
        for k, line in enumerate(PLAIN.splitlines())),
    "adafruit.log": lambda: printed(
        "t= {t} |\tAccl:\tx= {a[0]:.6f} |\ty= {a[1]:.6f} |\tz= {a[2]:.6f} |\t"
        "Gyro:\tx= {w[0]:.6f} |\ty= {w[1]:.6f} |\tz= {w[2]:.6f}"),
    "units.log": lambda: printed(
        "t: {t} Accel X: {a[0]:.6f} \tY: {a[1]:.6f} \tZ: {a[2]:.6f} g "
        "Gyro X: {w[0]:.5f} Y: {w[1]:.5f} Z: {w[2]:.5f} deg/s", G, DEG),
    "gy521.txt": lambda: printed(
        "t = {t} | AcX = {a[0]:.0f} | AcY = {a[1]:.0f} | AcZ = {a[2]:.0f} | Tmp = 26.53"
        " | GyX = {w[0]:.0f} | GyY = {w[1]:.0f} | GyZ = {w[2]:.0f}", G / 16384, DEG / 131),
    "esp32.log": lambda: "ESP-ROM:esp32s3-20210327\nI (300) main: start\n" + printed(
        "I ({t}) imu: acc {a[0]:.6f} {a[1]:.6f} {a[2]:.6f} gyr {w[0]:.6f} {w[1]:.6f} {w[2]:.6f}"),
    "monitor.txt": lambda: f"12:00:00.000 -> {NAMES}\n" + printed(
        "{clock} -> {a[0]:.6f},{a[1]:.6f},{a[2]:.6f},{w[0]:.6f},{w[1]:.6f},{w[2]:.6f}"),
    "monitor_keys.txt": lambda: printed(
        "{clock} -> ax:{a[0]:.6f} ay:{a[1]:.6f} az:{a[2]:.6f} gx:{w[0]:.6f} gy:{w[1]:.6f} "
        "gz:{w[2]:.6f}"),
    "lines.jsonl": lambda: "\n".join(json.dumps(row) for row in of_json(
        lambda k: {"ts": int(millis()[k]), "accel": dict(zip("xyz", FORCE[k], strict=True)),
                   "gyro": dict(zip("xyz", RATE[k], strict=True))})),
    "serial.log": lambda: "hello\n" + "\n".join(json.dumps(row) for row in of_json(
        lambda k: {"millis": int(millis()[k]), "acc": FORCE[k].tolist(), "gyr": RATE[k].tolist()})),
    "list.json": lambda: json.dumps({"device": "it", "samples": of_json(
        lambda k: dict(zip(HEADER.split(","), [int(millis()[k]), *FORCE[k], *RATE[k]],
                           strict=True)))}),
    "columns.json": lambda: json.dumps(
        dict(zip(HEADER.split(","), [c.tolist() for c in (millis(), *both())], strict=True))),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_a_custom(tmp_path: Path, name: str) -> None:
    data = TEXTS[name]()
    (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    found = read(tmp_path / name)
    if name == "missing.csv":
        kept = ~np.isin(np.arange(len(T)) % 9, [3])
        check(found, time_s=T[kept], force=FORCE[kept], rate=RATE[kept])
    else:
        check(found)


@pytest.mark.parametrize(("metadata", "sign"), [("ios", -1.0), ("android", 1.0)])
def test_signs_of_a_phone(tmp_path: Path, metadata: str, sign: float) -> None:
    """Sensor Logger's iPhones read downward where its Android phones read upward."""
    for name, values in (("TotalAcceleration", sign * FORCE), ("Gyroscope", RATE)):
        text = rows([NS, T + 0.25, *values.T[::-1]], "time,seconds_elapsed,z,y,x")
        (tmp_path / f"{name}.csv").write_text(text)
    (tmp_path / "Metadata.csv").write_text(f"version,device name,platform\n3,it,{metadata}\n")
    check(read(tmp_path))
    if sign < 0:
        text = f"version,platform,standardisation\n3,{metadata},true\n"
        (tmp_path / "Metadata.csv").write_text(text)
        check(read(tmp_path), force=-FORCE)


def test_a_watch(tmp_path: Path) -> None:
    header = "time,seconds_elapsed," + ",".join(
        f"{kind}{axis}" for kind in ("rotationRate", "gravity", "acceleration") for axis in "XYZ"
    )
    columns = [NS, T, *RATE.T, *(-0.95 * FORCE / G).T, *(-0.05 * FORCE / G).T]
    (tmp_path / "WristMotion.csv").write_text(rows(columns, header))
    check(read(tmp_path))


def test_a_sensor_that_may_be_there_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(rows([millis(), *both()], "millis,ax,ay,az,p,q,r"))
    assert "no gyroscope was recognised: if three of p, q, r are one, --columns gyro=" in said(
        read(path)
    )
    check(read(path, columns="gyro=p,q,r"))
    path.write_text(PLAIN)
    assert "was recognised" not in said(read(path))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("accel_gyro", None), ("accel", "accelerometer"), ("0A1B2C", None), ("a/g", None),
        ("Linear Acceleration (TYPE_LINEAR_ACCELERATION)", "linear acceleration"),
        ("WT_G_accel", "accelerometer"), ("TYPE_GYROSCOPE", "gyroscope"),
    ],
)  # fmt: skip
def test_a_name_of_two_kinds_or_of_letters_is_of_none(name: str, kind: str | None) -> None:
    assert kind_named(name) == kind


def test_of_an_unknown_unit_no_part_is_one() -> None:
    assert split_header("mag x (kGa)") == ("mag x (kGa)", None)
    milli = meaning("MagX[mGa]")
    assert milli is not None
    assert milli.unit is not None
    assert milli.unit.name == "mgauss"


@pytest.mark.parametrize(
    ("cell", "is_one"),
    [
        ("12:30:01.250", True), ("2024-05-01 12:30:01.250", True), ("12:30:01,250", True),
        ("2024-05-01T12:30:01+02:00", True), ("05/01/2024 02:30:01.250 PM", True),
        ("12:30:01.250,WT901,2024-05-01", False), ("12:30:01 -> 0.5", False), ("1,234.5", True),
        ("1'234.5", True), ("1.5D-03", True), ("1.234,5", True), ("ax", False), ("1.2.3.4", False),
    ],
)  # fmt: skip
def test_what_is_a_number_or_a_stamp(cell: str, is_one: bool) -> None:
    assert is_number(cell) is is_one


def test_a_name_among_cells_is_no_key(tmp_path: Path) -> None:
    """An address of hardware has colons."""
    path = tmp_path / "pen.csv"
    lines = PLAIN.splitlines()
    path.write_text("\n".join([f"{lines[0]},device", *(f"{x},d8:2e:1f:0a" for x in lines[1:])]))
    check(read(path))


def test_numbers_of_markers_above_a_header_are_no_row(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text("id,1,1,1,2,2,2\n\n" + PLAIN)
    check(read(path))


def test_counts_between_words(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    path.write_text(rows(whole([millis(), *both(G / 16384, DEG / 131)]), HEADER))
    check(read(path))


@pytest.mark.parametrize(
    "cell", ["1" * 200_000 + "x", "12:00" + "1" * 200_000 + "!", "1,111" * 40_000, "ax:1" * 50_000]
)
def test_a_cell_without_an_end_takes_no_time(cell: str) -> None:
    start = time.process_time()
    is_number(cell)
    line_form([f"{cell},2,3"] * 3)
    assert time.process_time() - start < 1.0


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"{}", "holds no samples, expected JSON with an object for each sample"),
        (b"[1, 2, 3]", "holds no samples"),
        (b'[{"a": 1}, {"a": 2}]', "no sensor's columns among a"),
        (b"[" * 100, "100 tables or lists within each other"),
        (b'{"t": 1', "Expecting ',' delimiter"),
    ],
)
def test_json_without_samples(tmp_path: Path, data: bytes, sentence: str) -> None:
    (tmp_path / "pen.json").write_bytes(data)
    with pytest.raises(InputError, match=sentence):
        read(tmp_path / "pen.json")


def test_a_row_for_each_reading_beside_columns_of_the_same_name(tmp_path: Path) -> None:
    lines = [
        line
        for t, f, w in zip(T, FORCE, RATE, strict=True)
        for line in (
            f"acc,{t:.3f},{f[0]:.6f},{f[1]:.6f},{f[2]:.6f},1",
            f"gyro,{t:.3f},{w[0]:.6f},{w[1]:.6f},{w[2]:.6f},2",
        )
    ]
    path = tmp_path / "pen.csv"
    path.write_text("\n".join(["sensor,time,x,y,z,accelerometer x", *lines]))
    check(read(path))
