"""The work behind ``pen-mhe codegen``: an estimator of a pen as C in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmark.console import console
from codegen.export import export_texts
from codegen.exportable import exportable
from codegen.folder import export_paths, write_export
from codegen.sizes import find_target, measure
from estimation.apart import check_apart
from estimation.output_folder import check_folder
from models.pen import pen_model
from models.pen_file import load_pen, pen_paths


@dataclass(frozen=True)
class CodegenRequest:
    """What to export, and where to.

    Parameters
    ----------
    pen, sensors, writing_area, rest : see `models.pen_file.load_pen` and `models.pen.pen_model`
    estimator : one of `codegen.exportable.EXPORTABLE`
    horizon, deadline_s : of an estimator with a window; None takes the default
    lag_samples : at which such an estimator tells of earlier instants too
    late_samples : of a filter, measurements back that it takes a late one; None takes the default
    real : ``double`` or ``float``
    form : one of `estimation.loop.STAGES`; None takes the default of the precision
    watch : whether it watches its sensors
    prefix : of the files' and the functions' names
    command : that asked for it, for the README
    """

    pen: str
    sensors: Sequence[str] | None
    writing_area: bool
    rest: bool
    estimator: str
    horizon: int | None
    deadline_s: float | None
    lag_samples: tuple[int, ...]
    late_samples: int | None
    real: str
    form: str | None
    watch: bool
    prefix: str
    output: Path
    command: str


def run_codegen(request: CodegenRequest) -> None:
    """Write an estimator as C and say what it takes.

    Raises
    ------
    InputError
        For what does not fit; the message says what was expected.
    """
    model = pen_model(
        load_pen(request.pen),
        request.sensors,
        writing_area=request.writing_area,
        rest=request.rest,
    )
    chosen = exportable(request.estimator, model, watch=request.watch, **_settings(request))
    export = export_texts(chosen, request.real, form=request.form, prefix=request.prefix)
    check_folder(request.output)
    check_apart(export_paths(export, request.output), {"the pen file": pen_paths(request.pen)})
    target = find_target()
    with Console(stderr=True).status("compiling, to measure"):
        sizes = None if target is None else measure(export, target)
    write_export(export, request.output, sizes, request.command)
    console.print(
        f"{request.estimator} in {request.real}, {model.n_x} states, written to {request.output}"
    )
    if sizes is not None:
        console.print(
            f"{sizes.target}: flash {sizes.flash} B, RAM {sizes.ram} B "
            f"and {sizes.state} B a state, {sizes.estimate} B an estimate; stack {sizes.stack} B"
        )


def _settings(request: CodegenRequest) -> dict[str, Any]:
    """Return the settings that were given."""
    asked = {
        "horizon": request.horizon,
        "deadline_s": request.deadline_s,
        "lag_samples": request.lag_samples or None,
        "late_samples": request.late_samples,
    }
    return {name: value for name, value in asked.items() if value is not None}
