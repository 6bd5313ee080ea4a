"""Kinds of files beside those first known, by rules that hold for a family of writers.

Each was refused once, or misread, but for ``named.csv``, which a form of lines is to leave alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from recordings.foreign.column_names import ACCELEROMETER, meaning
from recordings.foreign.groups import numbered_axes
from recordings.formats.line_forms import line_form
from recordings.turn_factor import rough_turn
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
)
from tests.recordings.swings import swinging

NAMES = ("ax", "ay", "az", "gx", "gy", "gz")
NS = np.round(T * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
CLOCK = [f"14:{k // 6000:02d}:{k // 100 % 60:02d}.{k % 100:02d}0" for k in range(len(T))]


def each() -> Iterator[tuple[int, list[float], list[float]]]:
    """Yield the stamp in ms, force and rate of every instant."""
    yield from zip(millis().tolist(), FORCE.tolist(), RATE.tolist(), strict=True)


def numbered() -> Iterator[tuple[int, str, float]]:
    """Yield a stamp, a name and a value for every number."""
    for t, f, w in each():
        yield from ((t, name, value) for name, value in zip(NAMES, [*f, *w], strict=True))


def vector(values: list[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def teleplot() -> str:
    return "".join(f">{name}:{t}:{value:.6f}\n" for t, name, value in numbered())


def teleplot_of_its_own_stamps() -> str:
    """Each number with the stamp of its line, and a unit; one kind after the other."""
    lines = []
    for t, f, w in each():
        for k, (name, unit, values) in enumerate((("acc", "m/s²", f), ("gyro", "rad/s", w))):
            lines += [f">{name}_{a}:{t + k}.{j}:{v:.6f}§{unit}|g"
                      for j, (a, v) in enumerate(zip("xyz", values, strict=True))]  # fmt: skip
    return "\n".join(lines)


def echoed() -> str:
    """What ``ros2 topic echo`` prints of sensor_msgs/Imu."""
    messages = []
    for ns, f, w in zip(NS, FORCE, RATE, strict=True):
        message = [f"header:\n  stamp:\n    sec: {ns // 10**9}\n    nanosec: {ns % 10**9}",
                   "  frame_id: imu\norientation_covariance:\n- -1.0\n- 0.0"]  # fmt: skip
        for key, values in (("angular_velocity", w), ("linear_acceleration", f)):
            axes = (f"  {a}: {v:.7f}" for a, v in zip("xyz", values, strict=True))
            message += [f"{key}:", *axes]
        messages.append("\n".join(message))
    return "\n---\n".join(messages) + "\n---\n"


def sensors_of_ids() -> str:
    """Rows of two devices in turn, the second of which lies still."""
    lines = ["imu_id,t_ms," + ",".join(NAMES)]
    for t, f, w in each():
        lines.append(f"1,{t}," + ",".join(f"{v:.6f}" for v in (*f, *w)))
        lines.append(f"2,{t + 3},0,0,9.8,0,0,0.01")
    return "\n".join(lines)


def json_of(data: object) -> str:
    return json.dumps(data)


def packets() -> str:
    """Four samples a packet, stamped once, as Movesense's IMU6 has them."""
    found = []
    for k in range(0, len(T), 4):
        acc, gyro = (
            [vector(row) for row in one[k : k + 4].tolist()] for one in (FORCE, RATE / DEG)
        )
        packet = {"Timestamp": int(millis()[k]), "ArrayAcc": acc, "ArrayGyro": gyro}
        found.append(json_of({"IMU6": packet}))
    return "\n".join(found)


def edge_impulse() -> str:
    named = [(f"acc{a}", "m/s2") for a in "XYZ"] + [(f"gyr{a}", "d/s") for a in "XYZ"]
    return json_of({"protected": {"ver": "v1", "alg": "none", "iat": 1564128599}, "payload": {
        "device_type": "WAND", "interval_ms": 10,
        "sensors": [{"name": name, "units": unit} for name, unit in named],
        "values": np.column_stack(both(1.0, DEG)).tolist()}})  # fmt: skip


def device_motion() -> str:
    """W3C's event, with what the hand does of the force apart."""
    moved = FORCE - FORCE.mean(axis=0)
    return json_of([
        {"timeStamp": t + 0.3, "acceleration": vector(m), "interval": 10,
         "accelerationIncludingGravity": vector(f),
         "rotationRate": dict(zip(("alpha", "beta", "gamma"), w, strict=True))}
        for (t, f, _), m, w in zip(each(), moved.tolist(), (RATE / DEG).tolist(), strict=True)
    ])  # fmt: skip


TEXTS: dict[str, Callable[[], str]] = {
    "teleplot.txt": teleplot,
    "teleplot.log": teleplot_of_its_own_stamps,
    "echo.yaml": echoed,
    "influx.txt": lambda: "\n".join(
        f"imu,device=pen {','.join(f'{n}={v:.6f}' for n, v in zip(NAMES, [*f, *w], strict=True))} "
        f"{ns}" for (_, f, w), ns in zip(each(), NS, strict=True)),
    "fields.csv": lambda: "_time,_value,_field,_measurement\n" + "\n".join(
        f"{t},{values[k]:.6f},{name},imu" for name, values in zip(NAMES, both(), strict=True)
        for k, t in enumerate(millis())),
    "axes.csv": lambda: "time,sensor,axis,value\n" + "\n".join(
        f"{t},{'acc' if name[0] == 'a' else 'gyro'},{name[1]},{value:.6f}"
        for t, name, value in numbered()),
    "vectornav.log": lambda: "\n".join(
        f"{clock} -> $VNYMR,+011.0,-002.3,+000.1,+0.21,-0.02,+0.40,"
        + ",".join(f"{v:+.6f}" for v in (*f, *w)) + "*6E"
        for clock, (_, f, w) in zip(CLOCK, each(), strict=True)),
    "tagged.txt": lambda: "\n".join(
        f"$IMU,{t}," + ",".join(f"{v:.6f}" for v in (*f, *w)) + "*4A" for t, f, w in each()),
    "teraterm.log": lambda: "\n".join(
        f"[2024-05-01 {clock}] " + ",".join(f"{v:.6f}" for v in (*f, *w))
        for clock, (_, f, w) in zip(CLOCK, each(), strict=True)),
    "named.csv": lambda: "device,millis," + ",".join(NAMES) + "\n" + "\n".join(
        f"pen,{line}" for line in rows([millis(), *both()]).splitlines()),
    "999.csv": lambda: rows(
        [millis(), *both()], "millis," + ",".join(NAMES)) + "9000" + ",-999" * 6 + "\n",
    "ended.txt": lambda: rows([millis(), *both()], end=";\n"),
    "letters.txt": lambda: "\n".join(
        f"{t} {kind} {v[0]:.6f} {v[1]:.6f} {v[2]:.6f}" for t, f, w in each()
        for kind, v in (("A", f), ("G", w))),
    "ids.csv": sensors_of_ids,
    "id.csv": lambda: rows(
        [np.full(len(T), 2), T, *both(G, DEG)],
        "SensorId,TimeStamp (s)," + ",".join(
            f"{s}{a} ({u})" for s, u in (("Acc", "g"), ("Gyro", "deg/s")) for a in "XYZ")),
    "trident.csv": lambda: rows(
        [T, *both(1.0, DEG)],
        "time_s,ax_m/s/s,ay_m/s/s,az_m/s/s,gx_deg/s,gy_deg/s,gz_deg/s"),
    "sbg.txt": lambda: rows(
        [np.round(T * 1e6).astype(int), *both(1.0, DEG)],
        "timestamp\taccelX\taccelY\taccelZ\tgyroX\tgyroY\tgyroZ\n(us)"
        + "\t(m.s^-2)" * 3 + "\t(deg.s^-1)" * 3, sep="\t"),
    "channels.csv": lambda: rows(
        [millis(), *both()], "millis," + ",".join(
            f"{s} Channel {k}" for s in ("Accel", "Gyro") for k in range(3))),
    "spelt.csv": lambda: rows(
        [T, *both(G, DEG)], "time (sec)," + ",".join(
            f"{s}{a} ({u})" for s, u in (("A", "G's"), ("G", "degrees/second")) for a in "xyz")),
    "greek.csv": lambda: rows([T, *both()], "t/s,a_x,a_y,a_z,ω_x,ω_y,ω_z"),
    "above.csv": lambda: rows(
        [T, *both(), *both(2.0, 2.0)],
        f"time,{','.join(['pen'] * 6)},{','.join(['wrist'] * 6)}\n"
        f"s,{','.join(NAMES)},{','.join(NAMES)}"),
    "rate.txt": lambda: "Fs=100\n" + rows(both(), " ".join(NAMES), sep=" "),
    "interval.csv": lambda: "# interval_ms: 10\n" + rows(both(), ",".join(NAMES)),
    "recorded.csv": lambda: "Recorded at," + ",".join(NAMES) + "\n" + "\n".join(
        f"2024-05-01 {clock} UTC,{line}" for clock, line in
        zip(CLOCK, rows(both()).splitlines(), strict=True)),
    "edge.json": edge_impulse,
    "motion.json": device_motion,
    "packets.json": packets,
    "batches.jsonl": lambda: "\n".join(json_of({"ts": int(millis()[k]), "samples": [
        dict(zip(NAMES, row, strict=True)) for row in np.column_stack(both())[k:k + 10].tolist()
    ]}) for k in range(0, len(T), 10)),
    "payload.jsonl": lambda: "\n".join(json_of({"topic": "pen", "payload": json_of(
        {"t": t} | dict(zip(NAMES, [*f, *w], strict=True)))}) for t, f, w in each()),
    "printed.txt": lambda: "\n".join(
        str({"t": t, "accel": vector(f), "gyro": vector(w)}) for t, f, w in each()),
    "apart.json": lambda: json_of({
        "accelerometer": [{"timestamp": t, **vector(f)} for t, f, _ in each()],
        "gyroscope": [{"timestamp": t, **vector(w)} for t, _, w in each()]}),
    "nested.json": lambda: json_of({"time_ms": millis().tolist(), "accel": {
        a: FORCE[:, k].tolist() for k, a in enumerate("xyz")}, "gyro": {
        a: RATE[:, k].tolist() for k, a in enumerate("xyz")}}),
    "matrix.json": lambda: json_of({"fs": 100, "acc": FORCE.tolist(), "gyr": RATE.tolist()}),
    "split.json": lambda: json_of({"columns": ["t", *NAMES], "data": [
        [t, *f, *w] for t, f, w in each()]}),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_a_kind(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(TEXTS[name]().rstrip("\n") + "\n")  # a line without an end was cut off
    check(read(path))


def test_a_unit_is_told_by_rates_too_rough_for_a_fit(tmp_path: Path) -> None:
    """A gyroscope in deg/s beside an accelerometer in m/s², shaken, was taken for rad/s."""
    t, rate, up = swinging(3)
    shaken = 9.81 * up + 5.0 * np.sin(40 * t)[:, None]
    for unit, factor in (("rad_s", 1.0), ("deg_s", DEG), ("mdeg_s", DEG / 1000)):
        columns = [np.round(t * 1e6).astype(int), *shaken.T, *(rate / factor).T]
        path = tmp_path / f"{unit}.csv"
        path.write_text(rows(columns, "micros,ax,ay,az,gx,gy,gz"))
        assert f"gyro from gx, gy, gz in {unit} (gravity turns" in said(read(path))
    rough = rough_turn(t, shaken, t, rate)
    assert rough is not None
    assert rough.most > 0.7
    assert rough.correlation > 0.5
    assert rough_turn(t, shaken, t, np.ones_like(rate)) is None
    assert rough_turn(t, shaken, t[:0], rate[:0]) is None


def test_no_header_and_nothing_that_shows_a_gyroscope(tmp_path: Path) -> None:
    path = tmp_path / "pen.csv"
    others = np.random.default_rng(2).normal(0, 1, RATE.shape)
    path.write_text(rows([millis(), *FORCE.T, *others.T]))
    with pytest.raises(InputError, match=r'--columns "time=1;accel=2,3,4;gyro=5,6,7"'):
        read(path)
    path.write_text(rows([millis(), *others.T, *RATE.T]))
    with pytest.raises(InputError, match=r"no sensor's columns among 1, 2, 3"):
        read(path)
    path.write_text(rows([np.arange(len(T)), *FORCE.T, 0 * T + 25]))
    with pytest.raises(InputError, match='"time=100Hz" for rows at that rate'):
        read(path)
    check(read(path, columns="time=100Hz"), rate=None)


def test_the_start_and_rate_of_an_e4(tmp_path: Path) -> None:
    path = tmp_path / "ACC.csv"
    counts = np.round(FORCE / G * 64).astype(int)
    above = "".join(f"{', '.join([one] * 3)}\n" for one in ("1793714709.00", "100.000000"))
    path.write_text(above + rows(list(counts.T)))
    found = check(read(path), rate=None, force_within=0.08)
    assert "ACC.csv: rows at 100 Hz, as its first two say" in said(found)
    assert "in counts of 1/64 g" in said(found)


def test_gravity_is_included_where_a_name_says_so() -> None:
    told = meaning("accelerationIncludingGravity.x")
    assert told is not None
    assert told.kind == ACCELEROMETER
    assert meaning("gyroAngleX") is None
    assert meaning("Ax (foo)") == meaning("Ax (foo)", "gyro.csv")
    assert numbered_axes(["acc_0", "acc_1", "acc_2", "acc_3"]) == {}


@pytest.mark.parametrize(
    "line",
    ["ACC,1,2,3", ">ax:12|xy", "imu ax=1 12", "time,ax,ay", "33,1;", "a: 1", "[12:00:00] hello"],
)
def test_a_line_alone_has_no_form_of_these(line: str) -> None:
    assert line_form([line, "once upon a time", "there was,x"]) is None
