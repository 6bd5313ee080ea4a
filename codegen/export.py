"""An estimator as C: header, loop and generated functions."""

from __future__ import annotations

from dataclasses import dataclass, replace

from codegen.estimate_fields import offsets
from codegen.exportable import Exportable
from codegen.generated import generated_source, prototypes
from codegen.header import header, title
from codegen.interface import interface
from codegen.names import check_prefix
from codegen.number_format import PRECISIONS, Precision
from codegen.roots import in_roots
from codegen.structures import StaticC
from codegen.template import filled
from estimation.loop import (
    GENERATED,
    STAGES,
    Loop,
    engine_sources,
    loop_constants,
    model_fields,
    stage_sizes,
)
from estimation.result import result_layout
from models.escaped import in_comment
from models.names import unknown
from models.state_space import StateSpaceModel

FORMS = {"double": "covariance", "float": "root"}
"""Precision → form of the Kalman stage: covariances do not last in single precision."""


@dataclass(frozen=True, repr=False)
class Export:
    """The C of an estimator.

    Parameters
    ----------
    exported : what was exported
    prefix : of the files' and the public functions' names
    precision : of real numbers
    form : one of `estimation.loop.STAGES`
    header, source, generated : texts of <prefix>.h, <prefix>.c and <prefix>_model.c
    """

    exported: Exportable
    prefix: str
    precision: Precision
    form: str
    header: str
    source: str
    generated: str

    def __repr__(self) -> str:
        lines = sum(text.count("\n") for text in (self.header, self.source, self.generated))
        return (
            f"<{title(self.exported, self.precision, self.form)} "
            f"{self.prefix}.h, {self.prefix}.c and {self.prefix}_model.c: {lines} lines>"
        )


def export_texts(
    exported: Exportable,
    real: str = "double",
    *,
    form: str | None = None,
    prefix: str = "pen",
) -> Export:
    """Write an estimator as C.

    Parameters
    ----------
    real : ``double`` or ``float``
    form : one of `estimation.loop.STAGES`; None takes that of `FORMS`
    prefix : of names; small letters, digits and underscores

    Raises
    ------
    InputError
        If names of C cannot begin with the prefix, or `real` or `form` is unknown.
    """
    check_prefix(prefix)
    if real not in PRECISIONS:
        raise unknown("precision", real, PRECISIONS)
    if form is not None and form not in STAGES:
        raise unknown("form", form, STAGES)
    precision, form = PRECISIONS[real], form or FORMS[real]
    model, loop, start = exported.model, exported.loop, exported.start.copy()
    if form == "root":
        loop, start = in_roots(model, loop, start)
    parts = [
        *prototypes(loop.functions, prefix),
        "",
        *_constants(model, loop, precision),
        *_loop(replace(exported, loop=loop), form, prefix, precision),
        interface(replace(exported, loop=loop), start, prefix, precision),
    ]
    front = filled(
        "front.c",
        prefix=prefix,
        title=in_comment(title(exported, precision, form)),
        functions="\n".join(precision.functions(parts)),
        generated=GENERATED,
        entry=loop.entry,
    )
    return Export(
        exported,
        prefix,
        precision,
        form,
        header(exported, prefix, precision, form),
        "\n".join([front, *parts]),
        generated_source(loop.functions, prefix, precision),
    )


def _loop(exported: Exportable, form: str, prefix: str, precision: Precision) -> list[str]:
    """Return structures, the loop's own sources, and its structure's value."""
    loop, model = exported.loop, exported.model
    fields = {
        "model": model_fields(model, loop, form=form),
        "memory": loop.memory,
        "result": offsets(result_layout(model, loop.lags)),
        **loop.fields,
    }
    functions = {f.name(): (f.n_in(), f.n_out()) for f in loop.functions}
    static, kind = StaticC(precision, prefix, functions), loop.entry.capitalize()
    value = static.structure(kind, fields, loop.entry)
    return [
        *static.types,
        *engine_sources(loop, STAGES[form]),
        *static.arrays,
        f"static const {kind} self = {value};",
    ]


def _constants(model: StateSpaceModel, loop: Loop, precision: Precision) -> list[str]:
    """Return the macros of a loop, real numbers in the precision."""
    return [
        *(f"#define {name} {value}" for name, value in stage_sizes(model).items()),
        *_numbers(loop, precision),
    ]


def _numbers(loop: Loop, precision: Precision) -> list[str]:
    return [
        f"#define {name} "
        + (precision.number(value) if isinstance(value, float) else str(int(value)))
        for name, value in loop_constants(loop, precision.dtype).items()
    ]
