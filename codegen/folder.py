"""An export in a folder: everything that another machine's compiler needs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from codegen.constant_readings import constant_sensors, detected_sensors, given_names
from codegen.example import example_program
from codegen.export import Export, export_texts
from codegen.exportable import exportable, is_timed
from codegen.header import state_units, title
from codegen.names import macros
from codegen.sizes import Sizes, find_target, measure, size_words
from codegen.template import AtTemplate, filled
from estimation.output_folder import prepare_folder
from estimation.outputs import derived_outputs
from models.errors import InputError
from models.escaped import code_span, in_comment, in_markdown
from models.state_space import StateSpaceModel

FLOAT_TIMES = """Times are handed over as `double`, and kept in single precision relative to an
origin that follows them: intervals stay right however long the estimator runs. Where a gap lies
within a window, intervals are resolved to about 1e-7 of the gap until it has left the window."""
DERIVED = """    /* estimate.derived[@place] in @unit, estimate.derived_std[@place] */

`derived` has what people read and is derived from the states, with standard deviations in
`derived_std`: @names."""
CONSTRAINED = """Bounds and inequalities hold in the estimate. Where the search for the active
rows fails, pen-mhe itself tries again with OSQP; here the best point so far is returned, with
`@{PREFIX}_STATUS_SOLVER_FAILED`."""
TIMED = """Answers within @deadline s of a call, going by the clock: with as many stages as there is
time for (`@{PREFIX}_STATUS_TIME_LIMIT`), or a prediction (`@{PREFIX}_STATUS_PREDICTED`). Without a
clock it does not compile."""
DOUBLE_TIMES = "Times are kept in double precision, as they are handed over."


def export_c(
    estimator: str,
    model: StateSpaceModel,
    folder: str | Path,
    *,
    real: str = "double",
    form: str | None = None,
    prefix: str = "pen",
    **settings: Any,
) -> Export:
    """Write an estimator as C into a folder, measure what it takes, return what was written.

    Parameters
    ----------
    estimator : one of `codegen.exportable.EXPORTABLE`
    folder : to write to; made where there is none
    real, form, prefix : see `codegen.export.export_texts`
    settings : of the estimator, by keyword; the rest takes its defaults

    Raises
    ------
    InputError
        If there is no C export of the estimator, something does not fit, or a file cannot be
        written.
    """
    export = export_texts(exportable(estimator, model, **settings), real, form=form, prefix=prefix)
    prepare_folder(Path(folder))
    target = find_target()
    sizes = None if target is None else measure(export, target)
    write_export(export, Path(folder), sizes, "pen_mhe.export_c")
    return export


def export_files(export: Export, sizes: Sizes | None, command: str) -> Mapping[str, str]:
    """Return file name → text of a whole export.

    Parameters
    ----------
    sizes : what was measured; None where there was no compiler
    command : that made it, for the README
    """
    prefix = export.prefix
    about = title(export.exported, export.precision, export.form)
    return {
        f"{prefix}.h": export.header,
        f"{prefix}.c": export.source,
        f"{prefix}_model.c": export.generated,
        "main.c": example_program(export),
        "CMakeLists.txt": filled("CMakeLists.txt", prefix=prefix, title=in_comment(about)),
        "README.md": _readme(export, sizes, command, about),
    }


def write_export(export: Export, folder: Path, sizes: Sizes | None, command: str) -> None:
    """Write a whole export; see `export_files`.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    prepare_folder(folder)
    for name, text in export_files(export, sizes, command).items():
        try:
            (folder / name).write_text(text, "utf-8")
        except OSError as error:
            raise InputError(
                f"output {folder / name}: {error.strerror}, expected a file that can be written"
            ) from None


def _readme(export: Export, sizes: Sizes | None, command: str, about: str) -> str:
    model = export.exported.model
    is_float = export.precision.c_type == "float"
    names = given_names(model)
    unread = [*constant_sensors(model), *detected_sensors(model)]
    added = [stacked.sensor.name for stacked in unread]
    return filled(
        "README.md",
        prefix=export.prefix,
        PREFIX=export.prefix.upper(),
        estimator=export.exported.estimator,
        title=f"`{export.exported.estimator}`"
        + in_markdown(about.removeprefix(export.exported.estimator)),
        command=code_span(command),
        precision=f"`{export.precision.c_type}`",
        some_columns=", ".join(map(code_span, names[:3])) + ", …",
        first_state=macros(model.state_names)[0],
        first_unit=in_comment(state_units(model)[0][1]),
        derived=_derived_words(export),
        constraints=_constraint_words(export),
        deadline=_deadline_words(export),
        constants=f"\nThe step adds the readings of {in_markdown(', '.join(added))} itself.\n"
        if added
        else "",
        times=FLOAT_TIMES if is_float else DOUBLE_TIMES,
        sizes=size_words(sizes),
    )


def _derived_words(export: Export) -> str:
    """Return how to read the first output that is no state, and what there is; "" without any."""
    derived, capital = derived_outputs(export.exported.model), export.prefix.upper()
    if not derived.names:
        return ""
    words = AtTemplate(DERIVED).substitute(
        place=f"{capital}_DERIVED_{macros(derived.names)[0]}",
        unit=in_comment(derived.units[0]),
        names=", ".join(map(code_span, derived.names)),
    )
    return f"{words}\n"


def _deadline_words(export: Export) -> str:
    if not is_timed(export.exported):
        return ""
    deadline_s = f"{export.exported.loop.fields['deadline']:g}"
    words = AtTemplate(TIMED).substitute(PREFIX=export.prefix.upper(), deadline=deadline_s)
    return f"\n{words}\n"


def _constraint_words(export: Export) -> str:
    if not export.exported.loop.fields.get("n_c"):
        return ""
    words = AtTemplate(CONSTRAINED).substitute(PREFIX=export.prefix.upper())
    return f"\n{words}\n"
