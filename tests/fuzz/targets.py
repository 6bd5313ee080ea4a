"""Every reader of files as a function of bytes, for a fuzzer.

A reader may take a file, or refuse it with an `InputError` of one printable line. Anything else,
an `UnforeseenError` too, is a finding.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from benchmark.runner.about import NAME as RUN
from benchmark.runner.about import read_about
from benchmark.runner.outcome_lines import NAME as JOURNAL
from benchmark.runner.outcome_lines import outcome_journal
from benchmark.runner.tables import RESULTS, SERIES, read_tables, write_tables
from benchmark.verdicts.claims import load_claims
from models.bundled import bundled_pens
from models.errors import InputError, UnforeseenError
from models.own_models import OwnSensor, own_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.shown_text import LONGEST_SENTENCE
from models.state_space import StateSpaceModel
from models.turntable import load_turntable
from pen_mhe.tuning.pen_text import PenText
from recordings.checked import check as check_recording
from recordings.formats.dpoint import CAMERA_FILE, STYLUS_FILE
from recordings.formats.imu_array import FILE as ARRAY
from recordings.formats.imu_array import read_imu_array
from recordings.ink import ink_points_mm
from recordings.read import read_recording, read_written
from recordings.truths.read import read_truth
from recordings.written import WrittenRecording
from tests.fuzz.foreign_seeds import NINE_AXES, SPLIT
from tests.fuzz.seeds import IDENTITY, TASK, results_tables, seeds

LONGEST_S = 1.0
OF_A_SKETCH = b"millis,ax,ay,az,gx,gy,gz\n" + b"".join(
    b"%d,0.1,0.2,9.8,1,%d,3\n" % (10 * k, k) for k in range(8)
)

MEMORY = Path("/dev/shm")
"""Files in memory, where a system has them: on a disk, opening two costs ten times what most
readers do with them."""


@cache
def folder() -> Path:
    """Where inputs become files; it stays until the process ends."""
    made = tempfile.TemporaryDirectory(
        prefix="pen-mhe-fuzz-", dir=MEMORY if MEMORY.is_dir() else None
    )
    KEPT.append(made)
    return Path(made.name)


KEPT: list[tempfile.TemporaryDirectory[str]] = []


def written(name: str, data: bytes) -> Path:
    path = folder() / name
    path.write_bytes(data)
    return path


@cache
def pen(name: str) -> PenConfig:
    return load_pen(name)


@cache
def own() -> StateSpaceModel:
    """A model of one's own with an input."""
    return own_model(
        "cart",
        {"position_m": (0.0, 1.0), "speed_m_s": (0.0, 1.0)},
        lambda x, w, dt, u: [x[0] + dt * x[1], x[1] + dt * u[0] + w[0] * dt**0.5],
        1,
        {"gps": OwnSensor(lambda x: x[:1], {"x": "m"}, 0.1)},
        inputs=("push_m_s2",),
    )


@cache
def nine_axes() -> PenConfig:
    """The reference pen with a magnetometer and a tablet."""
    return load_pen(written("nine.toml", pen_with(b"")))


def pen_with(recording: bytes) -> bytes:
    """Return a pen file that says how recordings are read."""
    sensors, _, _ = NINE_AXES.partition(b"[recording]")
    return bundled_pens()["reference"].read_bytes() + sensors + recording


def _foreign(data: bytes) -> None:
    name = "pen.txt.gz" if data.startswith(b"\x1f\x8b") else "pen.txt"
    _said(read_written(written(name, data), nine_axes()))


def _checked(data: bytes) -> None:
    found = check_recording(written("pen.txt", data), nine_axes())
    assert all(line.isprintable() for line in found.text.splitlines())


def _of_pen(data: bytes) -> None:
    """A pen file's own words on recordings, and a recording read by them."""
    config = load_pen(written("own.toml", pen_with(b"[recording]" + data)))
    _said(read_written(written("pen.csv", OF_A_SKETCH), config))


def _asked(data: bytes) -> None:
    """What somebody says of a file: columns, or units behind an equals sign in front."""
    text = data.decode("utf-8", "replace")
    path = written("pen.csv", OF_A_SKETCH)
    if not text.startswith("="):
        _said(read_written(path, nine_axes(), columns=text))
        return
    parts = (part.partition("=") for part in text[1:].split(","))
    units = {key.strip(): unit for key, _, unit in parts}
    _said(read_written(path, nine_axes(), units=units))


def _merged(data: bytes) -> None:
    parts = data.split(SPLIT)[:4]
    paths = [written(f"part{k}.csv", part) for k, part in enumerate(parts)]
    _said(read_written(paths, nine_axes()))


def _truth(data: bytes) -> None:
    track = read_truth(written("truth.csv", data), nine_axes())
    assert all(sentence.isprintable() for sentence in track.said)
    between_s = (track.time_s[1:] + track.time_s[:-1])[:50] / 2
    for values, at in (
        (track.position, track.positions),
        (track.attitude, track.attitudes),
        (track.angles, track.angles_at),
    ):
        if values is not None:
            at(between_s)


def _said(found: WrittenRecording) -> None:
    assert all(sentence.isprintable() for sentence in found.sentences())


def _dpoint(data: bytes) -> None:
    stylus, _, camera = data.partition(SPLIT)
    written(STYLUS_FILE, stylus)
    written(CAMERA_FILE, camera)
    read_recording(folder(), pen("dpoint"))


def _results(data: bytes) -> None:
    good = results_tables()
    is_series = data[:1] == b"S"
    written(RESULTS, good[RESULTS] if is_series else data)
    written(SERIES, data[1:] if is_series else good[SERIES])
    read_tables(folder())


def _journal(data: bytes) -> None:
    written(JOURNAL, data)
    with outcome_journal(folder()) as journal:
        if journal.has(TASK, IDENTITY):
            read = journal.read(TASK, IDENTITY)
            write_tables([TASK], lambda task: read, folder())


def _pen_text(data: bytes) -> None:
    text = PenText.of(written("pen.toml", data))
    assert text is not None


TARGETS: Mapping[str, Callable[[bytes], object]] = MappingProxyType(
    {
        "pen": lambda data: load_pen(written("pen.toml", data)),
        "turntable": lambda data: load_turntable(written("turntable.toml", data)),
        "claims": lambda data: load_claims(written("claims.toml", data)),
        "pen_text": _pen_text,
        "csv": lambda data: read_recording(written("pen.csv", data), pen("reference")),
        "own_csv": lambda data: read_recording(written("own.csv", data), own()),
        "parquet": lambda data: read_recording(written("pen.parquet", data), pen("reference")),
        "foreign": _foreign,
        "checked": _checked,
        "merged": _merged,
        "json": lambda data: read_written(written("pen.json", data), nine_axes()),
        "of_pen": _of_pen,
        "asked": _asked,
        "truth": _truth,
        "workbook": lambda data: read_written(written("pen.xlsx", data), pen("reference")),
        "archive": lambda data: read_written(written("pen.zip", data), pen("reference")),
        "bag": lambda data: read_written(written("pen.bag", data), pen("reference")),
        "dpoint": _dpoint,
        "array": lambda data: read_imu_array(written(ARRAY, data).parent),
        "scan": lambda data: ink_points_mm(written("scan.jpg", data)),
        "run": lambda data: read_about(written(RUN, data).parent),
        "results": _results,
        "journal": _journal,
    }
)
"""Name of a reader → what reads bytes with it."""


class FindingError(AssertionError):
    """A reader did what it must not."""


@contextlib.contextmanager
def checked() -> Iterator[None]:
    """Raise `FindingError` unless what is done ends soon, and well or in one sentence."""
    start = time.process_time()
    try:
        with contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except UnforeseenError as error:
        raise FindingError(str(error)) from error
    except InputError as error:
        sentence = str(error)
        if not sentence.isprintable() or len(sentence) > LONGEST_SENTENCE:
            raise FindingError(f"not one printable line: {sentence!r}") from error
    if time.process_time() - start > LONGEST_S:
        raise FindingError(f"took {time.process_time() - start:.1f} s")


def check(target: str, data: bytes) -> None:
    """Read bytes with a reader of the table; raises `FindingError`, or what the reader raised."""
    _warm(target)
    with checked():
        TARGETS[target](data)


@cache
def _warm(target: str) -> None:
    """Import and compile what reading takes once, not with every file."""
    TARGETS[target](seeds(target)[0])
