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
from codegen.one_export import of_one_export
from codegen.sizes import Sizes, find_target, measure, size_words
from codegen.template import AtTemplate, filled
from estimation.output_file import write_whole_files
from estimation.output_folder import check_folder, make_folder
from estimation.outputs import derived_outputs
from models.escaped import code_span, in_comment, in_markdown
from models.state_space import StateSpaceModel

FLOAT_TIMES = """Times are handed over as `double`, and kept in single precision relative to an
origin that follows them: intervals stay right however long the estimator runs. Where a gap lies
within a window, intervals are resolved to about 1e-7 of the gap until it has left the window."""
DERIVED = """    /* estimate.derived[@place] in @unit, estimate.derived_std[@place] */

`derived` has what people read and is derived from the states, with standard deviations in
`derived_std`: @names."""
LAGS = """
    /* at estimate.lagged_time[@place], s: */
    /* estimate.lagged_mean[@place * @{PREFIX}_N_X + @state] in @unit */

`lagged_...` are of the states @lags samples before the newest, given all readings up to the newest,
with `lagged_covariance`. Samples are instants of measurements, of any sensor; a lag that reaches
further back than the window of that step is NaN in all of them."""
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
    watch: bool = False,
    **settings: Any,
) -> Export:
    """Write an estimator as C into a folder, measure what it takes, return what was written.

    Parameters
    ----------
    estimator : one of `codegen.exportable.EXPORTABLE`
    folder : to write to; made where there is none, in one that is there
    real, form, prefix : see `codegen.export.export_texts`
    watch : whether it watches its sensors, as far as that goes without going back in time: it says
        what it finds in the status and per sensor, and leaves out a sensor that alone stands out
    settings : of the estimator, by keyword; the rest takes its defaults

    Raises
    ------
    InputError
        If there is no C export of the estimator, something does not fit, or a file cannot be
        written.
    """
    chosen = exportable(estimator, model, watch=watch, **settings)
    export = export_texts(chosen, real, form=form, prefix=prefix)
    check_folder(Path(folder))
    target = find_target()
    sizes = None if target is None else measure(export, target)
    write_export(export, Path(folder), sizes, "pen_mhe.export_c")
    return export


def export_paths(export: Export, folder: Path) -> list[Path]:
    """Return where the files of an export are written."""
    return [folder / name for name in export_files(export, None, "")]


def export_files(export: Export, sizes: Sizes | None, command: str) -> Mapping[str, str]:
    """Return file name → text of a whole export.

    Parameters
    ----------
    sizes : what was measured; None where there was no compiler
    command : that made it, for the README
    """
    prefix = export.prefix
    about = title(export.exported, export.precision, export.form)
    header, source, generated = of_one_export(export)
    return {
        f"{prefix}.h": header,
        f"{prefix}.c": source,
        f"{prefix}_model.c": generated,
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
    files = export_files(export, sizes, command)
    make_folder(folder)
    write_whole_files(folder, files)


def _readme(export: Export, sizes: Sizes | None, command: str, about: str) -> str:
    model, name = export.exported.model, export.exported.estimator
    is_float = export.precision.c_type == "float"
    names = given_names(model)
    unread = [*constant_sensors(model), *detected_sensors(model)]
    added = [stacked.sensor.name for stacked in unread]
    return filled(
        "README.md",
        prefix=export.prefix,
        PREFIX=export.prefix.upper(),
        estimator=name,
        title=f"`{name}` {in_markdown(about.removeprefix(name))}",
        command=code_span(command),
        precision=f"`{export.precision.c_type}`",
        some_columns=", ".join(map(code_span, names[:3])) + ", …",
        first_state=macros(model.state_names)[0],
        first_unit=in_comment(state_units(model)[0][1]),
        derived=_derived_words(export),
        lags=_lag_words(export),
        constraints=_constraint_words(export),
        deadline=_deadline_words(export),
        watch=filled("watch.md", PREFIX=export.prefix.upper()) if export.exported.watch else "",
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


def _lag_words(export: Export) -> str:
    """Return how to read what is told of instants before the newest; "" where nothing is."""
    lags, model = export.exported.loop.lags, export.exported.model
    if not lags:
        return ""
    capital, state = export.prefix.upper(), macros(model.state_names)[0]
    words = AtTemplate(LAGS).substitute(
        PREFIX=capital,
        place=f"{capital}_LAG_{lags[0]}",
        state=f"{capital}_STATE_{state}",
        unit=state_units(model)[0][1],
        lags=", ".join(map(str, lags)),
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
