"""``pen-mhe tune``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmark.console import console, print_table
from benchmark.runner.interrupts import not_swallowed
from commands.option_groups import fields_group, grouped
from commands.options import names
from commands.options import units as read_units
from commands.pen_output import check_pen_output
from commands.recording_options import RecordingOptions
from commands.sentences import one_sentence
from pen_mhe.tuning.objectives import OBJECTIVES
from pen_mhe.tuning.parts import PARTS
from pen_mhe.tuning.result import Tuning
from pen_mhe.tuning.run import DEFAULT_FIT, DEFAULT_OBJECTIVE, DEFAULT_SCORE
from pen_mhe.tuning.run import tune as tune_pen

ObjectiveName = StrEnum("ObjectiveName", {name: name for name in OBJECTIVES})  # type: ignore[misc]
PartName = StrEnum("PartName", {name: name for name in PARTS})  # type: ignore[misc]
OBJECTIVE, FIT = ObjectiveName(DEFAULT_OBJECTIVE), PartName(DEFAULT_FIT)
SCORE = PartName(DEFAULT_SCORE)


@dataclass(frozen=True, kw_only=True)
class Tuned(RecordingOptions):
    """A recording and the pen whose numbers are fitted to it."""

    output: Annotated[Path, typer.Option(help="Pen file to write, .toml.")]


@grouped(tuned=fields_group(Tuned))
def tune(
    tuned: Tuned,
    *,
    objective: Annotated[ObjectiveName, typer.Option()] = OBJECTIVE,
    parameters: Annotated[
        str | None,
        typer.Option(
            help="Keys of the pen file, or their beginnings, with commas: motion,sensors.camera; "
            "by default those that the objective is good for."
        ),
    ] = None,
    fit: Annotated[PartName, typer.Option(help="What is fitted.")] = FIT,
    score: Annotated[PartName, typer.Option(help="What is scored.")] = SCORE,
) -> None:
    """Fit a pen's noise levels, walks and chains to a recording.

    Judges by the likelihood of the EKF's innovations, by how flat the tip
    stays while it presses, by elevation in gaps of the camera, or by frames
    that are withheld; ink and truth take no part. Writes the pen file anew,
    with what set which number.
    """
    with one_sentence():
        check_pen_output(tuned.output, tuned.pen, tuned.recording)
        with _working(objective.value) as on_progress, not_swallowed():
            found = tune_pen(
                tuned.recording,
                tuned.pen,
                objective=objective.value,
                sensors=names(tuned.sensors),
                parameters=names(parameters),
                fit=fit.value,
                score=score.value,
                units=read_units(tuned.units),
                columns=tuned.columns,
                strict=tuned.strict,
                writing_area=tuned.writing_area,
                on_progress=on_progress,
            )
        found.write(tuned.output)
        _report(found, tuned.output)


@contextmanager
def _working(objective: str) -> Iterator[Callable[[int, float], None] | None]:
    """Show the best value so far on a terminal; nothing in a pipe."""
    stderr = Console(stderr=True)
    if not stderr.is_terminal:
        yield None
        return
    with stderr.status(f"{objective}: building the filter") as status:
        unit = OBJECTIVES[objective].unit
        yield lambda evaluations, best: status.update(
            f"{objective}: {evaluations} evaluations, best {best:.6g} {unit}"
        )


def _report(found: Tuning, output: Path) -> None:
    print_table(
        f"{found.objective} on {found.fit}",
        ["key", "before", "after", "as good within"],
        [[n.key, f"{n.before:.4g}", f"{n.after:.4g}", n.range_text] for n in found.numbers],
    )
    console.print()
    print_table(
        f"worth on {found.score}",
        ["objective", "figure", "before", "after"],
        [
            [name, figure, f"{value:.6g}", f"{after.figures[figure]:.6g}"]
            for name, (before, after) in found.scores.items()
            for figure, value in before.figures.items()
        ],
    )
    console.print()
    for sentence in found.sentences():
        console.print(sentence)
    console.print(f"written to {output}")
