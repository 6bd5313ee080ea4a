"""What examples of libraries print: several lines an instant, counts, vectors in brackets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from recordings.formats.printed_blocks import block_form
from tests.recordings.formats.logger_files import DEG, FORCE, RATE, G, T, check, millis, read, said

AT_100_HZ = {"columns": "time=100Hz"}
HUNDREDTHS = {"force_within": 0.006, "rate_within": 0.006}


def mpu6050(k: int) -> str:
    """As Adafruit_MPU6050's basic_readings.ino prints an instant."""
    (ax, ay, az), (wx, wy, wz) = FORCE[k], RATE[k]
    return (
        f"Acceleration X: {ax:.2f}, Y: {ay:.2f}, Z: {az:.2f} m/s^2\r\n"
        f"Rotation X: {wx:.2f}, Y: {wy:.2f}, Z: {wz:.2f} rad/s\r\n"
        "Temperature: 28.14 degC\r\n\r\n"
    )


def lsm6ds(k: int) -> str:
    """As lsm6ds_lsm6dsox_simpletest.py prints an instant."""
    (ax, ay, az), (wx, wy, wz) = FORCE[k], RATE[k]
    return (
        f"Acceleration: X:{ax:.2f}, Y: {ay:.2f}, Z: {az:.2f} m/s^2\n"
        f"Gyro X:{wx:.2f}, Y: {wy:.2f}, Z: {wz:.2f} radians/s\n\n"
    )


def clocked(k: int) -> str:
    """The same as a serial monitor with times shows it, without empty lines."""
    lines = filter(None, lsm6ds(k).splitlines())
    return "".join(f"14:00:{T[k]:06.3f} -> {line}\n" for line in lines)


def i2cdev(k: int) -> str:
    """As MPU6050_raw.ino prints an instant."""
    counts = [*np.round(FORCE[k] / G * 16384), *np.round(RATE[k] / DEG * 131)]
    return "a/g:\t" + "\t".join(f"{n:.0f}" for n in counts) + "\n"


def log(instant: Callable[[int], str], rows: Sequence[int] = range(len(T))) -> str:
    return "".join(map(instant, rows))


def written(folder: Path, text: str) -> Path:
    path = folder / "serial.log"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("instant", [mpu6050, lsm6ds, i2cdev])
def test_without_times_the_rate_is_asked_for(tmp_path: Path, instant: Callable[[int], str]) -> None:
    path = written(tmp_path, "MPU6050 Found!\r\n" + log(instant))
    with pytest.raises(InputError, match="time=100Hz"):
        read(path)
    check(read(path, **AT_100_HZ), **HUNDREDTHS)


def test_times_of_a_serial_monitor(tmp_path: Path) -> None:
    check(read(written(tmp_path, log(clocked))), **HUNDREDTHS)


@pytest.mark.parametrize("instant", [mpu6050, lsm6ds, i2cdev])
@pytest.mark.parametrize("cut", [3, 45])
def test_a_log_that_begins_and_ends_within_an_instant(
    tmp_path: Path, instant: Callable[[int], str], cut: int
) -> None:
    """What is cut is no reading, not a number without its last digits either."""
    found = read(written(tmp_path, log(instant)[cut:-cut]), **AT_100_HZ)
    assert "before the header skipped" in said(found)
    assert cut == 3 or "left out, no row" in said(found)
    first = -(-cut // len(instant(0)))
    for sensor, values in (("accel", FORCE), ("gyro", RATE)):
        _, read_values = found.recording.sensor(sensor)
        n = len(read_values)
        assert n >= len(T) - 4
        np.testing.assert_allclose(read_values, values[first:][:n], atol=0.006)


def test_a_count_without_its_last_digits_is_none(tmp_path: Path) -> None:
    """A log that ends within its last count: that line has as many counts as others."""
    text = "a/g:\t0\t0\t16384\t0\t0\t-1234\n" * 50
    path = written(tmp_path, text[:-3])
    assert len(read(path, **AT_100_HZ).recording.time_s) == 49


@pytest.mark.parametrize("instant", [mpu6050, lsm6ds, i2cdev])
def test_a_board_that_starts_anew_between(tmp_path: Path, instant: Callable[[int], str]) -> None:
    boot = "ets Jul 29 2019 12:21:46\nrst:0x1 (POWERON_RESET),boot:0x13\n"
    text = log(instant, range(300)) + boot + log(instant, range(300, len(T)))
    found = check(read(written(tmp_path, text), **AT_100_HZ), **HUNDREDTHS)
    assert "repaired: serial.log: 2 lines left out" in said(found)


def test_a_line_that_is_lost_is_a_reading_less(tmp_path: Path) -> None:
    """An instant without its line of rates has a force alone, and no other instant moves."""
    lost = lsm6ds(400).splitlines()[0] + "\n\n"
    text = log(lsm6ds, range(400)) + lost + log(lsm6ds, range(401, len(T)))
    recording = read(written(tmp_path, text), **AT_100_HZ).recording
    np.testing.assert_allclose(recording.readings["accel"], FORCE, atol=0.006)
    kept = np.arange(len(T)) != 400
    np.testing.assert_allclose(recording.readings["gyro"][kept], RATE[kept], atol=0.006)
    assert np.isnan(recording.readings["gyro"][400]).all()


def test_counts_say_what_they_are_taken_for(tmp_path: Path) -> None:
    found = read(written(tmp_path, log(i2cdev)), **AT_100_HZ)
    assert "16384 per g and 131 per deg/s" in said(found)


def test_long_rows_are_no_instants() -> None:
    assert block_form(["10,ACC,0.1,0.2,9.8", "10,GYR,0.0,0.1,0.0"] * 20) is None


@pytest.mark.parametrize("opened", ["[{}]", "({})", "array([{}])", '"[{}]"'])
@pytest.mark.parametrize(("between", "header"), [(", ", True), ("  ", False)])
def test_vectors(tmp_path: Path, opened: str, between: str, header: bool) -> None:
    def vector(values: Sequence[float]) -> str:
        return opened.format(between.join(f"{x:.6f}" for x in values))

    lines = ["time,acc [m/s^2],gyro"] if header else []
    lines += [f"{t},{vector(a)},{vector(w)}" for t, a, w in zip(millis(), FORCE, RATE, strict=True)]
    lines[500:500] = ["12345,[0.1, 0.2", "Brownout detector was triggered"]
    options = {} if header else {"columns": "time=1;accel=2,3,4;gyro=5,6,7"}
    found = check(read(written(tmp_path, "\n".join(lines)), **options))
    assert "2 lines left out" in said(found)


def test_vectors_alone(tmp_path: Path) -> None:
    """Without times and names what they read shows, and the rate is asked for."""
    lines = [f"[{a[0]}, {a[1]}, {a[2]}],[{w[0]}, {w[1]}, {w[2]}]"
             for a, w in zip(FORCE, RATE, strict=True)]  # fmt: skip
    path = written(tmp_path, "\n".join(lines))
    with pytest.raises(InputError, match='"time=100Hz" for rows at that rate'):
        read(path)
    check(read(path, columns="time=100Hz"))
    check(read(path, columns="accel=1,2,3;gyro=4,5,6;time=100Hz"))
