"""An estimator's loop in C as data: what is compiled here, and exported for other machines."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from estimation.layout import Layout
from estimation.outputs import NAME as DERIVED
from estimation.status import REGULARITY_LIMIT, Status
from models.state_space import StateSpaceModel

GENERATED = "typedef int (*generated)(const real **, real **, integer *, real *, int);"
"""A function that CasADi wrote, for C."""
STAGES: Mapping[str, str] = MappingProxyType(
    {"covariance": "covariance_stage.c", "root": "root_stage.c"}
)
"""Form of the Kalman stage → its file; see `estimation.root_stage` for the second."""


@dataclass(frozen=True)
class Loop:
    """An estimator's loop in C.

    Parameters
    ----------
    sources : its files, compiled as one behind those of `engine_sources`
    entry : prefix of its functions ``<entry>_step`` and ``<entry>_batch``
    memory : layout of the estimator's state
    functions : groups of generated functions, one library each, those of
        `estimation.kalman_stage.stage_functions` among them
    fields : the estimator's C structure behind model, memory and result: arrays, numbers,
        None for no array, generated functions by their names, groups of arrays as
        mappings. An array of zeros is workspace, any other a table that nobody writes
    constants : macros

    Blocks and arrays are known by their names where a form of the stage or of a number asks
    for it: ``…covariance`` holds one, ``time_s``, ``times`` and ``at_time`` hold instants.
    """

    sources: Sequence[Path]
    entry: str
    memory: Layout
    functions: Sequence[Sequence[ca.Function]]
    fields: Mapping[str, Any]
    constants: Mapping[str, float] = field(default_factory=dict)


def model_fields(model: StateSpaceModel) -> dict[str, Any]:
    """Return the values of C's structure Model, in its order; see `Loop` for their kinds."""
    return {
        **{name: getattr(model, name) for name in ("n_x", "n_w", "n_y", "n_r")},
        "n_sensors": len(model.sensors),
        "saturation": model.saturation,
        "reach": None if model.reach is None else np.asarray(model.reach, dtype=float),
        "regularity_limit": REGULARITY_LIMIT,
        "row_needs": model.row_needs,
        "measured_rows": model.measured_rows,
        "first_row": np.cumsum([0, *(sensor.n_r for sensor in model.sensors)]),
        **{name: name for name in ("predict", "update", "retract", "regularity")},
        DERIVED: ctypes.c_void_p() if model.outputs is None else DERIVED,
    }


def engine_sources(loop: Loop, stage: str = "covariance") -> list[str]:
    """Return a loop's C as it is compiled, without what is declared in front of it.

    Parameters
    ----------
    stage : one of `STAGES`
    """
    front = ("engine.c", STAGES[stage], "rest.c")
    return [
        *((resources.files("estimation") / name).read_text("utf-8") for name in front),
        *(source.read_text("utf-8") for source in loop.sources),
    ]


def loop_constants(loop: Loop) -> dict[str, float]:
    """Return the macros in front of a loop: the bits of `Status`, and its own."""
    bits = {f"STATUS_{name}": member.value for name, member in Status.__members__.items()}
    return {**bits, **loop.constants}
