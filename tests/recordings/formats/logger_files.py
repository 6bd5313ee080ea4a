"""What other people's loggers would write of one motion: a rod that swings for eight seconds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from models.arrays import Array
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.units import STANDARD_GRAVITY_M_S2 as G
from recordings.read import read_written
from recordings.written import WrittenRecording

PEN: PenConfig = load_pen("reference")
DEG = np.pi / 180
T = np.arange(800) / 100
_ANGLE = 0.5 * np.sin(2 * np.pi * 0.3 * T)
_RATE = 0.5 * 2 * np.pi * 0.3 * np.cos(2 * np.pi * 0.3 * T)
_DRAW = np.random.default_rng(1)
FORCE: Array = G * np.column_stack([np.sin(_ANGLE), 0.05 + 0 * T, np.cos(_ANGLE)])
FORCE += _DRAW.normal(0, 0.01, FORCE.shape)
RATE: Array = np.column_stack([0 * T, -_RATE, 0 * T]) + _DRAW.normal(0, 0.001, FORCE.shape)


def rows(
    columns: Sequence[Array],
    header: str = "",
    *,
    sep: str = ",",
    decimal: str = ".",
    end: str = "\n",
) -> str:
    """Return a table as a text: whole numbers plainly, others with six digits behind the point."""
    lines = [header] if header else []
    for row in zip(*columns, strict=True):
        cells = (f"{x:d}" if isinstance(x, int | np.integer) else f"{x:.6f}" for x in row)
        lines.append(sep.join(cell.replace(".", decimal) for cell in cells))
    return end.join(lines) + end


def millis(start: int = 1000) -> Array:
    return np.round(T * 1000).astype(int) + start


def both(force: float = 1.0, rate: float = 1.0) -> list[Array]:
    """Return six columns: specific force and rate, in a unit of so many m/s² and rad/s."""
    return [*(FORCE / force).T, *(RATE / rate).T]


def whole(columns: Sequence[Array]) -> list[Array]:
    return [np.round(column).astype(int) for column in columns]


def read(path: Path | Sequence[Path], **options: object) -> WrittenRecording:
    return read_written(path, PEN, **options)  # type: ignore[arg-type]


def check(
    found: WrittenRecording,
    *,
    time_s: Array = T,
    force: Array | None = FORCE,
    rate: Array | None = RATE,
    force_within: float = 0.01,
    rate_within: float = 0.001,
) -> WrittenRecording:
    """Assert that a recording has the motion's readings, at its times but for a start."""
    for sensor, values, within in (("accel", force, force_within), ("gyro", rate, rate_within)):
        if values is not None:
            times, read_values = found.recording.sensor(sensor)
            np.testing.assert_allclose(times - times[0], time_s - time_s[0], atol=2e-6)
            np.testing.assert_allclose(read_values, values, atol=within)
    return found


def said(found: WrittenRecording) -> str:
    return "\n".join(found.sentences())
