"""The work behind ``pen-mhe benchmark``: table, figure, and what they were made with."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

from benchmark.first_light import Cell, CellKey, as_table, cell_keys, run_cell
from benchmark.registry import find_pen
from pen_mhe.console import console, print_table
from pen_mhe.figures import benchmark_figure, save
from pen_mhe.processes import finished

MOTION, DURATION_S = "turn", 3.0


def run_benchmark(output: Path, seeds: int, jobs: int) -> None:
    """Run every cell, print the table, write ``table.csv`` and, of seed 0, ``stroke.png``."""
    output.mkdir(parents=True, exist_ok=True)
    keys = cell_keys(range(seeds))
    found = {key: future.result() for key, future in finished("benchmark", _run, keys, jobs)}
    cells = [found[key] for key in keys]
    table = as_table(cells)
    table.to_csv(output / "table.csv", index=False)
    save(benchmark_figure([cell for cell in cells if cell.key.seed == 0]), output / "stroke.png")
    rows = [[_text(value) for value in row] for row in table.itertuples(index=False)]
    title = (
        f"RMS errors on the simulated motion '{MOTION}', {DURATION_S:g} s, median of {seeds} seeds"
    )
    print_table(title, [column.replace("_", " ") for column in table.columns], rows)
    console.print(
        f"\nPython {platform.python_version()}, casadi {version('casadi')}, "
        f"numpy {version('numpy')}, "
        f"pen-mhe {version('pen-mhe')}; table and figure (seed 0) in {output}"
    )


def _run(key: CellKey) -> Cell:
    return run_cell(find_pen("reference"), key, MOTION, DURATION_S)


def _text(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
