"""The work behind ``pen-mhe benchmark``: table, figure, and what they were made with."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

from benchmark.first_light import as_table, run_cells
from benchmark.registry import CONFIGURATIONS, ESTIMATORS, find_pen
from pen_mhe.console import console, print_table, progress
from pen_mhe.figures import benchmark_figure, save

STROKE, DURATION_S = "turn", 3.0


def run_benchmark(output: Path, seed: int) -> None:
    """Run every cell, print the table, write ``table.csv`` and ``stroke.png``."""
    output.mkdir(parents=True, exist_ok=True)
    with progress("benchmark") as start:
        advance = start(len(CONFIGURATIONS) * len(ESTIMATORS))
        recording, cells = run_cells(find_pen("reference"), STROKE, DURATION_S, seed, advance)
    table = as_table(cells)
    table.to_csv(output / "table.csv", index=False)
    save(benchmark_figure(recording, cells), output / "stroke.png")
    rows = [[_text(value) for value in row] for row in table.itertuples(index=False)]
    title = f"RMS errors on the simulated stroke '{STROKE}', {DURATION_S:g} s, seed {seed}"
    print_table(title, [column.replace("_", " ") for column in table.columns], rows)
    console.print(
        f"\nPython {platform.python_version()}, casadi {version('casadi')}, "
        f"numpy {version('numpy')}, "
        f"pen-mhe {version('pen-mhe')}; table and figure in {output}"
    )


def _text(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
