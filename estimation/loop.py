"""An estimator's loop in C as data: what is compiled here, and exported for other machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from estimation.layout import Layout
from estimation.lifted import is_plain
from estimation.linearisation import READINGS, TRANSITION, stage_fields
from estimation.outputs import NAME as DERIVED
from estimation.stage_limits import stage_limits
from estimation.status import REGULARITY_LIMIT, Status
from estimation.stored import QUAD, stride
from models.state_space import StateSpaceModel

GENERATED = """typedef int (*generated)(const real **, real **, integer *, real *, int);
typedef struct {
    generated evaluate;
    const real *constants;
    integer n_arguments, n_results;
} Function;"""
"""A function that CasADi wrote, for C: its numbers are an argument of their own, the last."""
NO_FUNCTION = ""
"""In place of a function's name: the loop does without it."""
IN_COVARIANCES = ("reflections.c", "root_use.c", "covariance_form.c", "covariance_use.c")
"""What loops ask of an array that holds a covariance, or a root where that is needed."""
QUADS = "quads.c"
STAGES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "covariance": (
            *(*IN_COVARIANCES, "linearise.c", "root_stage.c"),
            *(QUADS, "covariance_stage.c"),
        ),
        "root": ("reflections.c", "root_use.c", "linearise.c", "root_stage.c", "root_form.c"),
    }
)
"""Form of the Kalman stage → its files; see `codegen.roots` for the second."""
FORM_BEHIND_POINTERS = (QUADS, *IN_COVARIANCES, "kernel_call.c")
"""The form "covariance" whose stage is a library of its own, so that a loop knows no sizes."""


@dataclass(frozen=True)
class Loop:
    """An estimator's loop in C.

    Parameters
    ----------
    sources : its files, compiled as one behind those of `engine_sources`
    entry : prefix of its functions ``<entry>_step`` and ``<entry>_batch``
    memory : layout of the estimator's state
    functions : generated ones, those of `estimation.linearisation.loop_functions` among them
    fields : the estimator's C structure behind model, memory and result: arrays, numbers,
        None for no array, generated functions by their names (`NO_FUNCTION` for none), groups of
        arrays as mappings. An array of zeros is workspace, any other a table that nobody writes
    constants : macros
    lags : at which it tells of earlier instants too, in samples

    Blocks and arrays are known by their names where a form of the stage or of a number asks
    for it: ``…covariance`` holds one, ``time_s``, ``times`` and ``at_time`` hold instants.
    """

    sources: Sequence[Path]
    entry: str
    memory: Layout
    functions: Sequence[ca.Function]
    fields: Mapping[str, Any]
    constants: Mapping[str, float] = field(default_factory=dict)
    lags: tuple[int, ...] = ()


@dataclass(frozen=True)
class Pointers:
    """Room for pointers to numbers, which a generated function may use; constant ones or not."""

    size: int
    constant: bool


def model_fields(model: StateSpaceModel, loop: Loop, *, form: str = "covariance") -> dict[str, Any]:
    """Return the values of C's structure Model, in its order; see `Loop` for their kinds."""
    functions = loop.functions
    calling = [function for function in functions if not is_plain(function)]
    return {
        **{name: getattr(model, name) for name in ("n_x", "n_w", "n_y", "n_u", "n_row", "n_r")},
        "n_sensors": len(model.sensors),
        "stride": stride(model.n_x),
        "n_P": stride(model.n_x) ** 2,
        "row": np.zeros(model.n_row),
        "saturation": model.saturation,
        "reach": None if model.reach is None else np.asarray(model.reach, dtype=float),
        "regularity_limit": REGULARITY_LIMIT,
        "row_needs": model.row_needs,
        "measured_rows": model.measured_rows,
        "first_row": np.cumsum([0, *(sensor.n_r for sensor in model.sensors)]),
        **{name: name for name in (TRANSITION, READINGS, "retract", "regularity")},
        DERIVED: NO_FUNCTION if model.outputs is None else DERIVED,
        "arguments": Pointers(1 + max(f.sz_arg() for f in functions), constant=True),
        "results": Pointers(max(f.sz_res() for f in functions), constant=False),
        "integers": np.zeros(max((f.sz_iw() for f in calling), default=0), dtype=np.int64),
        "reals": np.zeros(max((f.sz_w() for f in calling), default=0)),
        **stage_fields(model, functions, form),
    }


def engine_sources(loop: Loop, form: Sequence[str]) -> list[str]:
    """Return a loop's C as it is compiled, without what is declared in front of it.

    Parameters
    ----------
    form : files of the Kalman stage, as of `STAGES`
    """
    form = (QUADS, *form) if loop.lags and QUADS not in form else form
    front = _texts("sizes.c", "arrays.c", "engine.c", *form, "rest.c")
    return [*front, *(source.read_text("utf-8") for source in loop.sources)]


def kernel_sources() -> list[str]:
    """Return the C of a Kalman stage alone, without what is declared in front of it."""
    stage = (
        "linearise.c",
        "reflections.c",
        "root_stage.c",
        "covariance_form.c",
        QUADS,
        "covariance_stage.c",
    )
    return _texts("sizes.c", "arrays.c", *stage, "kernel.c")


def stage_sizes(model: StateSpaceModel) -> dict[str, int]:
    """Return the macros by which a stage is compiled for models of one size."""
    return {"N_X": model.n_x, "N_W": model.n_w, "N_R": model.n_r, "QUAD": QUAD}


def _texts(*names: str) -> list[str]:
    return [(resources.files("estimation") / name).read_text("utf-8") for name in names]


def loop_constants(loop: Loop, real: type[np.floating] = np.float64) -> dict[str, float]:
    """Return the macros in front of a loop: the bits of `Status`, limits of its stage, its own."""
    bits = {f"STATUS_{name}": member.value for name, member in Status.__members__.items()}
    return {**bits, **stage_limits(real), **loop.constants}
