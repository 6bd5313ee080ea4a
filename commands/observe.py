"""The command ``observe``: what a choice of sensors can see."""

from __future__ import annotations

from typing import Annotated

import typer

from benchmark.runner.interrupts import not_swallowed
from commands.options import PenOption, SensorsOption, WritingAreaOption, names
from commands.sentences import one_sentence


def observe(
    pen: PenOption = "reference",
    sensors: SensorsOption = None,
    writing_area: WritingAreaOption = True,
    duration: Annotated[float, typer.Option(help="Of each motion, s.")] = 3.0,
) -> None:
    """Say what a choice of sensors can see, and what it cannot, in words of the state."""
    with one_sentence(), not_swallowed():
        from commands import observe_run  # models are slow to import

        observe_run.run_observe(pen, names(sensors), writing_area, duration)
