"""Good files of every format, small: what a fuzzer begins from."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import openpyxl
from PIL import Image
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from benchmark.runner.journal import LineFormat
from benchmark.runner.outcome_lines import OUTCOME_LINES
from benchmark.runner.tables import RESULTS, SERIES, write_tables
from benchmark.tasks.task import Outcome, Quantity, Series, Task, failed
from models.bundled import bundled_pens
from models.pen_file import load_pen
from recordings.formats.columns import TRUTH_PREFIX
from recordings.formats.tables import recording_to_table
from recordings.simulate_pen import simulate
from tests.fuzz.foreign_seeds import (
    NINE_AXES,
    SPLIT,
    foreign,
    json_lines,
    json_shapes,
    merged,
    truths,
)

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).resolve().parent / "corpus"
"""Folder of what fuzzing has found: a folder a target, a file a finding."""

TASK, IDENTITY = Task("pen", "b", "accel", "ekf", 1), "code"
_TIME_S = np.array([0.0, 0.5, 1.0])
OUTCOME = Outcome(
    "a model",
    (Quantity("tip", "mm", 1.5, -0.5, 2.5, True, 0.5), Quantity("t", "s", 1.0, 1.0, 1.0, False)),
    3,
    0.75,
    1e-3,
    2e-3,
    "mirror",
    "in the mirror",
    (Series("tip", "mm", _TIME_S, _TIME_S + 1, _TIME_S + 2, _TIME_S + 3),),
)
OUTCOMES = {TASK: OUTCOME, Task("pen", "a", "accel", "ekf", 0): failed("KeyError: 'what'")}
_LINES: LineFormat[Task, Outcome] = OUTCOME_LINES


@cache
def _workbook() -> bytes:
    rows = [["time (ms)", "ax", "ay", "az"], *([10 * k, 0.1 * k, 0.2, 9.8] for k in range(5))]
    file, book = io.BytesIO(), openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(file)
    return file.getvalue()


def _archive() -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name in ("Accelerometer", "Gyroscope"):
            rows = "\n".join(f"{k / 100},{k},2,9.8" for k in range(5))
            archive.writestr(f"{name}.csv", f"time,x,y,z\n{rows}\n")
    return file.getvalue()


@cache
def _bag() -> bytes:
    """A bag of ROS 1 with a few messages."""
    store = get_typestore(Stores.ROS1_NOETIC)
    kind = store.types
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "pen.bag"
        with Writer(path) as bag:
            name = "geometry_msgs/msg/PoseStamped"
            topic = bag.add_connection("/pose", name, typestore=store)
            for k in range(3):
                at = kind["builtin_interfaces/msg/Time"](sec=k, nanosec=10**8)
                head = kind["std_msgs/msg/Header"](seq=k, stamp=at, frame_id="pen")
                place = kind["geometry_msgs/msg/Point"](x=0.1, y=0.2, z=0.3)
                turn = kind["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
                pose = kind["geometry_msgs/msg/Pose"](position=place, orientation=turn)
                message = kind[name](header=head, pose=pose)
                bag.write(topic, 10**9 * k, store.serialize_ros1(message, name))
        return path.read_bytes()


@cache
def results_tables() -> Mapping[str, bytes]:
    """Both tables of a run: file name → content."""
    with tempfile.TemporaryDirectory() as scratch:
        write_tables(OUTCOMES, OUTCOMES.__getitem__, Path(scratch))
        return {name: (Path(scratch) / name).read_bytes() for name in (RESULTS, SERIES)}


@cache
def _table() -> tuple[bytes, bytes]:
    """A short recording as CSV and as Parquet, narrow: columns are what reading costs."""
    pen = load_pen("reference")
    recording = simulate(pen, ["accel", "gyro"], motion="turn", duration_s=0.03, seed=1)
    table = recording_to_table(recording, pen).round(4).iloc[:5]
    true = [name for name in table if name.startswith(TRUTH_PREFIX)]
    table = table.drop(columns=true[2:])
    parquet = io.BytesIO()
    table.to_parquet(parquet)
    return table.to_csv(index=False).encode(), parquet.getvalue()


def _dpoint() -> bytes:
    stylus = [
        {"t": 5 + 8 * k, "data": {"t": 8 * k, "accel": [0.0, 0.1, 9.8], "gyro": [0.1 * k, 0.0, 0.0],
                                  "pressure": 0.1}}
        for k in range(4)
    ]  # fmt: skip
    pose = {"position": [[0.0], [0.1], [0.5]], "orientation_mat": np.eye(3).tolist()}
    camera = [{"t": 6 + 20 * k, "data": pose} for k in range(2)]
    return json.dumps(stylus).encode() + SPLIT + json.dumps(camera).encode()


def _journal() -> bytes:
    lines = [
        {"identity": IDENTITY, **_LINES.encoded(task, outcome)}
        for task, outcome in OUTCOMES.items()
    ]
    return b"".join(json.dumps(line).encode() + b"\n" for line in lines)


def _array() -> bytes:
    file, n = io.BytesIO(), 4
    counts = np.arange(n * 6, dtype=np.int16).reshape(n, 2, 3)
    np.savez(file, t=np.arange(n) / 100, acc=counts, gyr=counts, pos_m=np.zeros((2, 3)))
    return file.getvalue()


def _scan() -> bytes:
    file, grey = io.BytesIO(), np.full((20, 30), 250, dtype=np.uint8)
    grey[8:12, 5:25] = 10
    Image.fromarray(grey).save(file, "jpeg", dpi=(150, 150))
    return file.getvalue()


RUN = {
    "command": "pen-mhe benchmark pen", "suites": ["pen"], "seeds": 2, "code": "abc",
    "versions": {"python": "3.11"}, "machine": {"cores": 2}, "git": {"dirty": False},
    "sessions": [{"seconds": 1.5, "tasks": 2, "finished": True}], "estimators": ["ekf"],
}  # fmt: skip


@cache
def seeds(target: str) -> tuple[bytes, ...]:
    """Return good inputs of a target of `tests.fuzz.targets`, and what was found once."""
    csv, parquet = _table()
    results = results_tables()
    toml = tuple(path.read_bytes() for path in bundled_pens().values())
    paths = (ROOT / "models/turntables").glob("[pt]*.toml")
    turntables = tuple(path.read_bytes() for path in sorted(paths))
    claims = (ROOT / "suites/pen/claims.toml").read_bytes()[:3000].rpartition(b"[[claim]]")[0]
    more = (toml[-1] + NINE_AXES,)
    good = {
        "pen": (*toml, *more),
        "of_pen": (NINE_AXES.partition(b"[recording]")[2],),
        "asked": (b"accel=ax,-ay,az;time=millis", b"a,b,c", b"time=100Hz", b"=gyro=g/16384"),
        "truth": truths(),
        "merged": (merged(),),
        "json": (
            json_lines(),
            b'{"samples": [' + b",".join(json_lines().split(b"\n")) + b"]}",
            *json_shapes(),
        ),
        "checked": foreign(),
        "turntable": turntables,
        "claims": (claims,),
        "pen_text": toml,
        "csv": (csv,),
        "own_csv": (b"time_s,gps_x,push_m_s2\n0,0.1,\n0.1,,1e-3\n",),
        "parquet": (parquet,),
        "foreign": foreign(),
        "workbook": (_workbook(),),
        "archive": (_archive(),),
        "bag": (_bag(),),
        "dpoint": (_dpoint(),),
        "array": (_array(),),
        "scan": (_scan(),),
        "run": (json.dumps(RUN).encode(),),
        "results": (results[RESULTS], b"S" + results[SERIES]),
        "journal": (_journal(),),
    }
    found = sorted((CORPUS / target).glob("*"))
    return (*good[target], *(path.read_bytes() for path in found))
