"""An export that watches: its statistics are Python's to the last bit, and what follows of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.export import Export, export_texts
from codegen.exportable import exportable
from codegen.exported import Exported
from codegen.folder import export_files
from estimation.status import Status
from estimation.watch.flags import Flag
from models.arrays import Array
from models.pen import pen_model
from pen_mhe import create_estimator
from recordings.simulate_pen import simulate
from tests.codegen.toolchains import HOST, compile_strictly
from tests.engines import needs_compiler
from tests.references.watch_alone import WatchAlone

pytestmark = needs_compiler
SENSORS = ("accel", "gyro", "camera")
MODEL = pen_model("reference", SENSORS)
WORDS = Status.STUCK | Status.OUTLIER | Status.INCONSISTENT | Status.LIVELIER | Status.LOST
SHORT: dict[str, dict[str, Any]] = {"ekf": {"late_samples": 20}, "mhe-rti": {"horizon": 4}}


def made(estimator: str, real: str, *, watch: bool = True) -> Export:
    return export_texts(exportable(estimator, MODEL, watch=watch, **SHORT[estimator]), real)


def stream(*, is_spoilt: bool = True, duration_s: float = 6.0) -> tuple[Array, Array]:
    """Return times and rows with a spike, a gyroscope that is stuck, a pose that is off, a brisk
    motion, a late row and a hole.
    """
    recording = simulate("reference", SENSORS, motion="handwriting", duration_s=duration_s, seed=5)
    time_s, y = recording.stacked(MODEL)[:2]
    if not is_spoilt:
        return time_s, y
    y[60, :3] += 90.0
    y[100:115, 3:6] = y[99, 3:6]
    y[150:210, 6:9] += 0.3
    shaken = np.random.default_rng(0).normal(size=(100, 6))
    y[420:520, :6] += shaken * [6.0, 6.0, 6.0, 2.0, 2.0, 2.0]
    y[560] = np.nan
    keep = (time_s < 4.8) | (time_s > 5.2)
    order = np.arange(keep.sum())
    order[[80, 81]] = order[[81, 80]]
    return time_s[keep][order], y[keep][order]


def watch_memory(exported: Exported) -> Array:
    """Return what the watch remembers: it stands last in the state."""
    watch = exported.exported.watch
    assert watch is not None
    raw = exported.state.raw[-8 * watch.layout.size :]
    return watch.layout.view(np.frombuffer(raw), "memory")


@pytest.mark.parametrize("estimator", ["ekf", "mhe-rti"])
def test_it_says_what_python_says_of_the_same(estimator: str) -> None:
    exported = Exported(made(estimator, "double"))
    expected = WatchAlone(create_estimator(estimator, MODEL, **SHORT[estimator]))
    exported.init()
    seen, words = np.zeros(len(MODEL.sensors), dtype=np.uint8), Status.SOLVED
    for t, row in zip(*stream(), strict=True):
        exported.take(float(t), row)
        estimate, said, flagged = expected.step(float(t), row)
        told = exported.layout.view(exported.told(), "mean")
        np.testing.assert_array_equal(told, estimate.state.mean)
        np.testing.assert_array_equal(watch_memory(exported), expected.memory)
        np.testing.assert_array_equal(exported.flagged, flagged)
        assert exported.status & WORDS == said
        seen, words = seen | flagged, words | said
    accel, gyro, camera = (int(seen[i]) for i in range(3))
    assert accel & Flag.OUTLIER
    assert gyro & Flag.STUCK
    assert camera & Flag.LEFT_OUT
    assert Status.LIVELIER in words


@pytest.mark.parametrize("real", ["double", "float"])
def test_a_sensor_that_lies_is_left_out_and_taken_back(real: str) -> None:
    exported = Exported(made("ekf", real))
    time_s, y = stream(is_spoilt=False)
    off = (time_s > 2.0) & (time_s < 3.0)
    y[off, 6:9] += 0.2
    exported.init()
    flags, status, errors = [], [], []
    for t, row in zip(time_s, y, strict=True):
        exported.take(
            1e6 + float(t), row
        )  # far from zero, where a float tells no two samples apart
        flags.append(exported.flagged)
        status.append(exported.status)
        errors.append(np.abs(exported.layout.view(exported.told(), "mean")[:3]).max())
    flagged = np.array(flags)
    out = (flagged[:, SENSORS.index("camera")] & Flag.LEFT_OUT) != 0
    assert not flagged[time_s <= 2.0].any()
    assert out[(time_s > 2.1) & (time_s < 3.0)].mean() > 0.9
    assert not out[time_s > 4.5].any()
    assert not any(word & (Status.LOST | Status.INCONSISTENT) for word in status)


def test_nothing_is_flagged_where_nothing_is_wrong() -> None:
    """And estimates are those of an export without a watch, to the last bit."""
    watched, bare = Exported(made("ekf", "double")), Exported(made("ekf", "double", watch=False))
    watched.init()
    bare.init()
    for t, row in zip(*stream(is_spoilt=False, duration_s=4.0), strict=True):
        for each in (watched, bare):
            each.take(float(t), row)
        for block in ("mean", "covariance", "status", "innovation"):
            one, other = (each.layout.view(each.told(), block) for each in (watched, bare))
            np.testing.assert_array_equal(one, other)
        assert not watched.flagged.any()


@pytest.mark.parametrize("real", ["double", "float"])
def test_compilers_have_nothing_to_say(real: str, tmp_path: Path) -> None:
    """Those of C11 neither; that of C99 made the libraries of all tests here."""
    compile_strictly(HOST, made("ekf", real), tmp_path, ("-O0", "-std=c11"))


def test_header_and_readme_say_what_it_does_and_what_not() -> None:
    files, bare = (export_files(made("ekf", "double", watch=w), None, "…") for w in (True, False))
    for flag in Flag:
        assert f"#define PEN_FLAG_{flag.name} {flag.value}u /* " in files["pen.h"]
    for i, sensor in enumerate(MODEL.sensors):
        assert f"PEN_SENSOR_{sensor.name.upper()} = {i}, " in files["pen.h"]
    assert "unsigned char flagged[PEN_N_SENSORS];" in files["pen.h"]
    assert "What only pen-mhe itself does" in files["pen.h"]
    assert "estimate.flagged[PEN_SENSOR_" in files["README.md"]
    assert not any("FLAG" in text or "watch" in text for text in bare.values())
