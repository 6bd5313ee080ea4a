"""``pen-mhe simulate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.lists import completing
from commands.options import PenOption, SensorsOption, names
from commands.sentences import one_sentence


def simulate(
    output: Annotated[Path, typer.Option(help="Recording to write, .parquet or .csv.")],
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    motion: Annotated[
        str, typer.Option(help="One of {motions}.", autocompletion=completing("motions"))
    ] = "turn",
    duration: Annotated[float, typer.Option(help="s")] = 3.0,
    seed: Annotated[int, typer.Option(help="Of motion, biases, noise and losses.", min=0)] = 0,
    speed: Annotated[float, typer.Option(help="Play the motion this many times faster.")] = 1.0,
    stamps: Annotated[
        str,
        typer.Option(
            help="Which instant a reading is given: {stamps}.",
            autocompletion=completing("stamps"),
        ),
    ] = "capture",
) -> None:
    """Write a simulated recording, with its truth in columns true_…"""
    from benchmark.console import console
    from estimation.apart import check_apart
    from models.pen_file import load_pen, pen_paths
    from recordings import simulate_pen
    from recordings.formats.tables import check_output, recording_to_table, write_table

    with one_sentence(), not_swallowed():
        check_apart([output], {"the pen file": pen_paths(pen)})
        check_output(output)
        config = load_pen(pen)
        recording = simulate_pen.simulate(
            config,
            names(sensors),
            motion=motion,
            duration_s=duration,
            seed=seed,
            speed=speed,
            stamps=stamps,
        )
        write_table(recording_to_table(recording, config), output)
        console.print(f"{len(recording.time_s)} instants, written to {output}")
