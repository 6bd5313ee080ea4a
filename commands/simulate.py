"""``pen-mhe simulate``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, get_args

import typer

from benchmark.console import console
from commands.options import PenOption, SensorsOption, names
from commands.sentences import one_sentence
from models.pen_file import load_pen
from recordings.simulate_pen import Stamps, motion_names
from recordings.simulate_pen import simulate as simulate_recording

MotionName = StrEnum("MotionName", {name: name for name in motion_names()})  # type: ignore[misc]
StampsName = StrEnum("StampsName", {name: name for name in get_args(Stamps)})  # type: ignore[misc]
CAPTURE, TURN = StampsName("capture"), MotionName("turn")


def simulate(
    output: Annotated[Path, typer.Option(help="Recording to write, .parquet or .csv.")],
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    motion: Annotated[MotionName, typer.Option()] = TURN,
    duration: Annotated[float, typer.Option(help="s")] = 3.0,
    seed: Annotated[int, typer.Option(help="Of motion, biases, noise and losses.", min=0)] = 0,
    speed: Annotated[float, typer.Option(help="Play the motion this many times faster.")] = 1.0,
    stamps: Annotated[StampsName, typer.Option(help="Which instant a reading is given.")] = CAPTURE,
) -> None:
    """Write a simulated recording, with its truth in columns true_…"""
    from recordings.formats.tables import recording_to_table, write_table  # slow to import

    with one_sentence():
        config = load_pen(pen)
        recording = simulate_recording(
            config,
            names(sensors),
            motion=motion.value,
            duration_s=duration,
            seed=seed,
            speed=speed,
            stamps=stamps.value,
        )
        write_table(recording_to_table(recording, config), output)
        console.print(f"{len(recording.time_s)} instants, written to {output}")
