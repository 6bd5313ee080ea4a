"""Exports as programs that ASan and UBSan watch, through good and ugly measurements."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from codegen.export import Export, export_texts
from codegen.exportable import exportable
from estimation.native import STRICT
from estimation.recording import Measurement
from estimation.status import UNSOLVED
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from tests.codegen.toolchains import stream_header, written
from tests.ekf_baseline.arrivals import STREAMS
from tests.mhe import pendulum

PROGRAM = Path(__file__).with_name("program.c")
SANITISERS = (
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
    "-g",
)
HOSTED = ("-DPEN_MHE_HOSTED", "-D_POSIX_C_SOURCE=199309L", "-ffp-contract=off", "-O1")
LATE = {"late_samples": 40}


@dataclass(frozen=True)
class Watched:
    """An export to watch.

    Parameters
    ----------
    stream : returns its model and measurements
    settings : of the estimator
    steps : per kind of measurements in the program
    watch : whether the export watches its sensors
    """

    estimator: str
    stream: Callable[[], tuple[StateSpaceModel, Sequence[Measurement]]]
    real: str = "double"
    form: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    steps: int = 1000
    watch: bool = False


@cache
def _simulated(pen: str, *sensors: str) -> tuple[StateSpaceModel, Sequence[Measurement]]:
    recording = simulate(pen, sensors, motion="handwriting", duration_s=0.6, seed=1)
    model = pen_model(load_pen(pen), sensors)
    return model, list(recording.measurements(model))


def _stream(name: str) -> Callable[[], tuple[StateSpaceModel, Sequence[Measurement]]]:
    return lambda: (STREAMS[name]().model, STREAMS[name]().measurements)


def _pen(pen: str, *sensors: str) -> Callable[[], tuple[StateSpaceModel, Sequence[Measurement]]]:
    return lambda: _simulated(pen, *sensors)


def _swinging() -> tuple[StateSpaceModel, Sequence[Measurement]]:
    return pendulum.model(), pendulum.simulate(60, seed=3)


def _held() -> tuple[StateSpaceModel, Sequence[Measurement]]:
    model = pendulum.model().bounded(s0_m=(-0.3, 0.3)).constrained(lambda x: x[0] + x[1] - 9)
    return model, pendulum.simulate(60, seed=3)


CAMERA = ("accel", "gyro", "camera")
EXPORTS: Mapping[str, Watched] = MappingProxyType(
    {
        "filter with a gate": Watched(
            "ekf", _stream("pen with a gate"), settings={"gate_probability": 0.999, **LATE}
        ),
        "filter in single precision": Watched("ekf", _pen("reference", *CAMERA), "float"),
        "filter at rest": Watched("ekf", _stream("at rest"), settings=LATE),
        "filter that watches": Watched("ekf", _pen("reference", *CAMERA), watch=True),
        "filter that watches in single precision": Watched(
            *("ekf", _pen("reference", *CAMERA), "float"), watch=True
        ),
        "window that watches": Watched(
            *("mhe-rti", _pen("reference", *CAMERA)),
            settings={"horizon": 4},
            steps=400,
            watch=True,
        ),
        "filter of dpoint": Watched("ekf", _pen("dpoint", *CAMERA), form="root"),
        "filter with inputs": Watched("ekf", _stream("inputs"), "float", settings=LATE),
        "window": Watched("mhe-rti", _swinging, settings={"horizon": 5}),
        "window with bounds": Watched(
            "mhe-rti", _held, settings={"horizon": 5, "sparse_noise": 1.0}, steps=1000
        ),
        "window with inputs": Watched(
            "mhe-rti",
            _stream("inputs"),
            settings={"horizon": 6, "lag_samples": (1, 4)},
            steps=1000,
        ),
        "window in single precision": Watched(
            *("mhe-rti", _pen("reference", *CAMERA), "float"),
            settings={"horizon": 4, "lag_samples": (2, 3), "deadline_s": 0.05},
            steps=400,
        ),
        "window of dpoint": Watched(
            "mhe-rti", _pen("dpoint", *CAMERA), settings={"horizon": 4}, steps=400
        ),
        "window with a writing area": Watched(
            *("mhe-rti", _pen("reference", "accel", "gyro", "contact", "area")),
            settings={"horizon": 4, "lag_samples": 2},
            steps=400,
        ),
    }
)
QUICK = ("filter with a gate", "filter that watches", "window with bounds", "window with inputs")
"""Those that CI takes."""


def export_of(watched: Watched) -> Export:
    """Return the C of an export to watch."""
    found = exportable(
        watched.estimator, watched.stream()[0], watch=watched.watch, **watched.settings
    )
    return export_texts(found, watched.real, form=watched.form)


def run(watched: Watched, export: Export, folder: Path) -> subprocess.CompletedProcess[str]:
    """Compile an export with sanitisers and the program, and run it; its folder is there."""
    written(export, folder)
    (folder / "program.c").write_text(PROGRAM.read_text("utf-8"), "utf-8")
    macros = [f"#define N_STEPS {watched.steps}", f"#define UNSOLVED {UNSOLVED.value}u"]
    stream = stream_header(export, watched.stream()[1])
    (folder / "stream.h").write_text("\n".join([*macros, stream]), "utf-8")
    files = ("pen.c", "pen_model.c", "program.c", "-o", "program", "-lm")
    command = ["gcc", *STRICT, *HOSTED, *SANITISERS, *files]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if built.returncode:
        return built
    return subprocess.run([str(folder / "program")], cwd=folder, capture_output=True, text=True)
