"""The work behind ``pen-mhe dpoint-table``: a cell per camera rate, phase and estimator.

Every finished cell is written at once; an interrupted run resumes where it was.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmark.camera import frames_per_kept
from benchmark.registry import EstimatorSettings, check_estimator, find_pen
from mhe.config import MheConfig
from models.errors import InputError
from models.sensors import PoseCamera
from pen_mhe.console import console, print_table
from pen_mhe.dpoint import is_dpoint_folder
from pen_mhe.estimate_run import CameraThinning, estimate_recording
from pen_mhe.load import load_recording
from pen_mhe.processes import finished

SENSORS = ("accel", "gyro", "camera")


@dataclass(frozen=True)
class TableCell:
    """What one run depends on; its hash names its file."""

    recording: str
    pen: str
    pen_settings: str
    estimator: str
    rate_hz: float
    phase: int
    horizon: int
    duration_s: float | None
    code: str

    @property
    def file_name(self) -> str:
        """Return a name that changes with anything the result depends on."""
        key = hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()[:12]
        return f"{self.estimator}-{self.rate_hz:g}Hz-{self.phase}-{key}.json"


def source_hash() -> str:
    """Return a hash of the package's own code and data: results of other code are not reused."""
    root = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for room in ("models", "estimation", "ekf_baseline", "mhe", "benchmark", "pen_mhe"):
        for path in sorted((root / room).rglob("*")):
            if path.suffix in (".py", ".c", ".toml"):
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def run_cell(cell: TableCell) -> dict[str, float]:
    """Run one cell and return its figures."""
    pen = find_pen(cell.pen)
    run = estimate_recording(
        load_recording(Path(cell.recording), pen),
        pen,
        cell.estimator,
        SENSORS,
        EstimatorSettings(mhe=MheConfig(horizon=cell.horizon)),
        CameraThinning(cell.rate_hz, cell.phase),
        cell.duration_s,
    )
    if run.ink is None:
        raise InputError(
            f"recording {cell.recording}: no scan or too short, expected ink to compare"
        )
    return {
        "ink_mm": run.ink.mean_distance_mm,
        "solved": run.history.solved_fraction,
        "steps": float(len(run.history)),
        "median_step_ms": float(np.median(run.history.step_time_s)) * 1e3,
        "p99_step_ms": float(np.quantile(run.history.step_time_s, 0.99)) * 1e3,
    }


def run_table(
    recording: Path,
    output: Path,
    pen: str,
    rates_hz: Sequence[float],
    estimators: Sequence[str],
    horizon: int,
    duration_s: float | None,
    jobs: int,
) -> None:
    """Run all cells that are not there yet, in processes, and print the table."""
    config = find_pen(pen)
    if not is_dpoint_folder(recording):
        raise InputError(f"recording {recording} is no D-POINT folder, expected one")
    load_recording(recording, config)
    for estimator in estimators:
        check_estimator(estimator)
    MheConfig(horizon=horizon)
    cameras = [s for s in config.sensors.values() if isinstance(s, PoseCamera)]
    code = source_hash()
    cells = [
        TableCell(
            str(recording.resolve()),
            pen,
            config.model_dump_json(),
            estimator,
            rate_hz,
            phase,
            horizon,
            duration_s,
            code,
        )
        for rate_hz in rates_hz
        for estimator in estimators
        for phase in range(frames_per_kept(cameras[0].rate_hz, rate_hz))
    ]
    output.mkdir(parents=True, exist_ok=True)
    todo = [cell for cell in cells if not (output / cell.file_name).exists()]
    # Long cells first, so that no process works alone at the end.
    todo.sort(key=lambda cell: cell.estimator == "ekf")
    failed: BaseException | None = None
    for cell, future in finished("dpoint-table", run_cell, todo, jobs):
        if (error := future.exception()) is not None:
            failed = failed or error
            continue
        path = output / cell.file_name
        partial = path.with_suffix(".part")
        partial.write_text(json.dumps(future.result()))
        partial.rename(path)
    if failed is not None:
        raise InputError(f"a cell of the table failed: {failed}")
    results = {cell: json.loads((output / cell.file_name).read_text()) for cell in cells}
    _print(results, rates_hz, estimators, duration_s)


def _print(
    results: dict[TableCell, dict[str, float]],
    rates_hz: Sequence[float],
    estimators: Sequence[str],
    duration_s: float | None,
) -> None:
    rows = []
    for rate_hz in rates_hz:
        for estimator in estimators:
            of_row = [
                figures
                for cell, figures in results.items()
                if cell.rate_hz == rate_hz and cell.estimator == estimator
            ]
            ink = np.array([figures["ink_mm"] for figures in of_row])
            steps = np.array([figures["steps"] for figures in of_row])
            solved = np.average([figures["solved"] for figures in of_row], weights=steps)
            rows.append(
                [
                    f"{rate_hz:g} Hz",
                    estimator,
                    f"{ink.mean():.4f} ({ink.min():.4f} to {ink.max():.4f})",
                    f"{len(ink)}",
                    f"{solved:.3%}",
                    f"{np.median([figures['median_step_ms'] for figures in of_row]):.3g}",
                    f"{max(figures['p99_step_ms'] for figures in of_row):.3g}",
                ]
            )
    part = "" if duration_s is None else f", first {duration_s:g} s"
    print_table(
        f"Mean ink distance, zero delay{part}",
        [
            "camera",
            "estimator",
            "ink distance / mm, mean (min to max) over phases",
            "phases",
            "solved",
            "median step / ms",
            "worst p99 step / ms",
        ],
        rows,
    )
    console.print(
        "\nzero delay: camera frames are used at the moment of their capture; "
        "the figures do not compare with causal ones"
    )
