"""Each check finds what it is for, and is silent on the same recording without."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from estimation.recording import Recording
from models.pen_file import load_pen
from recordings.checks.run import findings_of
from recordings.checks.sketch import BLOCK_ROWS, MOST_BLOCKS, Sketch
from recordings.checks.table import CHECKS
from recordings.finding import Finding, Severity, finding_lines, not_meant
from recordings.simulate_pen import simulate
from tests.recordings.rods import Rod, turned_rod

Sensors = dict[str, tuple[np.ndarray, np.ndarray]]


def rod(seed: int = 1) -> Rod:
    """Return a rod of 148 Hz."""
    return turned_rod(seed)


def slow(one: Rod) -> Sensors:
    every = round(0.1 / np.diff(one.time_s)[0])
    t = one.time_s[::every]
    return {"accel": (t, one.force[::every]), "gyro": (t, one.rate[::every])}


def with_gaps(one: Rod) -> Sensors:
    kept = (one.time_s % 3) < 2.6
    return {
        "accel": (one.time_s[kept], one.force[kept]),
        "gyro": (one.time_s[kept], one.rate[kept]),
    }


def mostly_gaps(one: Rod) -> Sensors:
    kept = (one.time_s % 3) < 0.9
    return {"accel": (one.time_s[kept], one.force[kept])}


def jittering(one: Rod) -> Sensors:
    rng, step = np.random.default_rng(0), np.diff(one.time_s)[0]
    t = np.sort(one.time_s + rng.uniform(0, 3 * step, len(one.time_s)))
    return {"accel": (t, one.force), "gyro": (t, one.rate)}


def clipped(one: Rod) -> Sensors:
    end = np.quantile(np.abs(one.rate), 0.97)
    return {"accel": (one.time_s, one.force), "gyro": (one.time_s, np.clip(one.rate, -end, end))}


def halved(one: Rod) -> Sensors:
    return {"accel": (one.time_s, one.force / 2), "gyro": (one.time_s, one.rate)}


def twice_as_fast(one: Rod) -> Sensors:
    return {"accel": (one.time_s, one.force), "gyro": (one.time_s, 2 * one.rate)}


def noisy(one: Rod) -> Sensors:
    rng = np.random.default_rng(0)
    more = one.force + rng.normal(0, 12 * one.noise[0], one.force.shape)
    return {"accel": (one.time_s, more), "gyro": (one.time_s, one.rate)}


def late(one: Rod) -> Sensors:
    return {"accel": (one.time_s, one.force), "gyro": (one.time_s + 0.06, one.rate)}


WRONG: dict[str, tuple[Callable[[Rod], Sensors], Severity, str]] = {
    "rates": (slow, Severity.REMARK, "9.87 readings a second"),
    "gaps": (with_gaps, Severity.REMARK, "the longest of 0.4"),
    "jitter": (jittering, Severity.REMARK, "stamps vary"),
    "clipping": (clipped, Severity.REMARK, "cut off at"),
    "scale": (halved, Severity.NOT_MEANT, "0.5"),
    "noise": (noisy, Severity.REMARK, "times"),
    "lag": (late, Severity.REMARK, "after those of accel"),
}


@pytest.mark.parametrize("name", WRONG)
def test_it_is_found(name: str) -> None:
    make, severity, words = WRONG[name]
    one = rod()
    found = findings_of(Recording.from_sensors(name, make(one)), one.pen())
    here = [finding for finding in found if finding.check == name]
    assert [finding.severity for finding in here][:1] == [severity], found
    assert words in here[0].what
    assert not not_meant([other for other in found if other.check != name])


def test_a_rate_that_gravity_contradicts() -> None:
    one = rod()
    found = findings_of(Recording.from_sensors("fast", twice_as_fast(one)), one.pen())
    assert [(f.check, f.where) for f in not_meant(found)] == [("scale", "gyro")]


def test_gaps_that_are_most_of_the_time() -> None:
    one = rod()
    found = findings_of(Recording.from_sensors("gaps", mostly_gaps(one)), one.pen())
    assert [(f.check, f.severity) for f in found] == [("gaps", Severity.NOT_MEANT)]


def test_a_late_camera() -> None:
    recording = simulate("reference", motion="handwriting", duration_s=15.0, stamps="arrival")
    (found,) = findings_of(recording.select(["accel", "gyro", "camera"]), load_pen("reference"))
    assert (found.check, found.where, found.severity) == ("camera", "camera", Severity.REMARK)
    assert "stamped 4" in found.what  # 45 ms


def test_a_camera_sees_a_wrong_mounting() -> None:
    sensors = ["accel", "gyro", "camera"]
    recording = simulate("reference", sensors, motion="handwriting", duration_s=10.0, seed=2)
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # above the table all the same
    readings = {n: v @ turn if n != "camera" else v for n, v in recording.readings.items()}
    wrong = Recording("turned", recording.time_s, readings)
    (found,) = findings_of(wrong, load_pen("reference"))
    assert (found.check, found.where, found.severity) == ("camera", "accel", Severity.NOT_MEANT)


def test_one_of_two_accelerometers_is_turned() -> None:
    sensors = ["accel_lower", "accel_upper"]
    recording = simulate("reference", sensors, motion="handwriting", duration_s=10.0, seed=2)
    turned = recording.readings["accel_upper"] @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    wrong = Recording("two", recording.time_s, {**recording.readings, "accel_upper": turned})
    (found,) = findings_of(wrong, load_pen("reference"))
    assert found.check == "mounting"
    assert found.where == "accel_lower, accel_upper"


def test_without_a_pen_nothing_is_compared_with_it() -> None:
    one = rod()
    recording = Recording.from_sensors("noisy", noisy(one))
    assert findings_of(recording, one.pen(), against_pen=False) == ()


@pytest.mark.parametrize("n", [1, 2, 3, 10, 60, 200])
@pytest.mark.parametrize("value", [0.0, 9.8, 1e300, np.nan])
def test_no_check_fails_on_what_is_odd(n: int, value: float) -> None:
    t, values = 0.01 * np.arange(n), np.full((n, 3), value)
    values[0] = 0.0
    for time_s in (t, 1e9 * (1 + t), 1e-7 * (1 + np.arange(n))):
        found = findings_of(
            Recording("odd", time_s, {"accel": values, "gyro": values}), load_pen("reference")
        )
        assert all("nan" not in finding.sentence() for finding in found)


def test_a_sketch_of_parts_is_that_of_the_whole() -> None:
    n = 30_000
    rng = np.random.default_rng(0)
    whole = Recording("long", 0.01 * np.arange(n), {"accel": rng.normal(size=(n, 3))})
    sketches = Sketch(), Sketch()
    sketches[0].take(whole)
    for part in np.array_split(np.arange(n), [100, 5_000, 5_001, 17_000]):
        sketches[1].take(whole.some_rows(part))
    for sketch in sketches:
        kept = sketch.end()
        assert kept is not None
        np.testing.assert_array_equal(kept[0].readings["accel"], whole.readings["accel"])
        assert len(kept[1]) == 0


def test_a_sketch_of_a_long_recording_is_short_and_even() -> None:
    n = 3 * BLOCK_ROWS * MOST_BLOCKS + 17
    sketch, t = Sketch(), 1e-3 * np.arange(n)
    for part in np.array_split(np.arange(n), 70):
        sketch.take(Recording("long", t[part], {"accel": np.zeros((len(part), 3))}))
    kept = sketch.end()
    assert kept is not None
    assert MOST_BLOCKS // 2 * BLOCK_ROWS <= len(kept[0].time_s) <= MOST_BLOCKS * BLOCK_ROWS
    assert kept[0].time_s[-1] > 0.9 * t[-1]
    assert set(np.flatnonzero(np.diff(kept[0].time_s) > 0.01)) == set(
        np.searchsorted(kept[0].time_s, kept[1])
    )
    assert Sketch().end() is None


def test_a_finding_in_lines() -> None:
    found = Finding("it hums", "accel", 0.8, "in the pen file\nhum = 0", span_s=(1.0, 2.0))
    assert finding_lines(found) == [
        "REMARK, reader: accel, 1 s to 2 s (80% sure)",
        "  it hums",
        "  -> in the pen file",
        "     hum = 0",
    ]


def test_names_of_checks_are_their_own() -> None:
    assert len({check.name for check in CHECKS}) == len(CHECKS)
