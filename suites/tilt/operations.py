"""Operations per sample, counted one way for all.

An operation is an instruction of a CasADi function that is neither an input, an output nor
a constant: a sum, a product, a root, a sine all count as one. Converting counts to g is the
same for all and is left out. So are the plain loops around the models' functions (copies,
inner products), and steps that a line search shortens: the models' counts are a little too
small. Passes count as full ones: where factors stay (`mhe.reuse`), fewer are made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType

import casadi as ca

from estimation.symbolic_stage import stage_functions
from mhe.config import MheConfig
from mhe.stage_functions import pass_functions, window_functions
from models.state_space import StateSpaceModel

FREE = (ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_PARAMETER)


def operations(function: ca.Function) -> int:
    """Return the operations of one call of a function of scalars (SX)."""
    codes = (function.instruction_id(k) for k in range(function.n_instructions()))
    return sum(code not in FREE for code in codes)


def ekf_operations(model: StateSpaceModel) -> int:
    """Return the operations of a step of the EKF."""
    of = _by_name(model)
    # Both means are brought back within a turn.
    return of["predict"] + of["update"] + 2 * of["retract"] + of["regularity"]


def mhe_operations(model: StateSpaceModel, horizon: int, passes: float, searches: bool) -> float:
    """Return the operations of a step of an MHE with a full window.

    Parameters
    ----------
    horizon : N
    passes : over the window, in the mean
    searches : whether every pass is tried by rolling it out, as ``mhe`` does
    """
    of, n = _by_name(model), horizon
    # The oldest stage is eliminated, the newest predicted.
    slide = (
        of["difference"] + of["update"] + of["predict"]
        + 2 * of["retract"] + of["move"] + of["regularity"]
    )  # fmt: skip
    forward = (n + 1) * of["update"] + n * (of["predict"] + of["difference"])
    back = (n + 1) * (of["smooth"] + of["spread"]) + n * of["retreat"]
    measured = (n + 1) * of["measure"] + n * of["shake"]
    if searches:
        tried = of["retract"] + n * of["move"] + measured
        return slide + measured + passes * (forward + back + tried)
    return slide + passes * (of["difference"] + forward + back + (n + 1) * of["retract"])


COUNTS: Mapping[str, Callable[[StateSpaceModel, float], float]] = MappingProxyType(
    {
        "ekf": lambda model, passes: float(ekf_operations(model)),
        "mhe-rti": lambda model, passes: mhe_operations(
            model, MheConfig().horizon, passes, searches=False
        ),
        "mhe": lambda model, passes: mhe_operations(
            model, MheConfig().horizon, passes, searches=True
        ),
    }
)
"""Estimator → operations of a step with a model and so many passes in the mean."""


def operations_of_step(estimator: str, model: StateSpaceModel, passes: float) -> float:
    """Return the operations of a step of an estimator that has a row in `COUNTS`."""
    return COUNTS[estimator](model, passes)


def uncounted(estimator: str) -> str:
    """Say why an estimator has no figure of operations; empty for one that has a row."""
    if estimator in COUNTS:
        return ""
    return (
        f"The operations of {estimator} are not counted: it has no row in "
        "suites.tilt.operations.COUNTS."
    )


@lru_cache(maxsize=16)
def _by_name(model: StateSpaceModel) -> Mapping[str, int]:
    stage = stage_functions(model)
    functions = (*stage, *window_functions(model), *pass_functions(model, *stage[:2]))
    return {function.name(): operations(function) for function in functions}
