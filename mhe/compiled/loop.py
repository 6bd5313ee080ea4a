"""The window's loop in C, around a model's generated functions."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from estimation.engine import CompiledEngine, Loop
from estimation.layout import Layout
from estimation.linearisation import loop_functions, triangle
from estimation.loop import NO_FUNCTION
from estimation.outputs import derived_outputs
from estimation.rest import rest_constants, rest_fields
from estimation.stored import stored
from mhe import constraint_rows
from mhe.arrival_cost import ARRIVAL_COSTS
from mhe.compiled.workspace import workspace
from mhe.config import Clock, RealTimeConfig
from mhe.domain import limits
from mhe.loss import LEAST_SQUARES
from mhe.reuse import SETTLED, reuse_threshold
from mhe.rules import ACTIVE_SET, DESCENT, FIRST, most_active
from mhe.second_start import SECOND_START, cost_limits
from mhe.stage_functions import carry_function, window_functions
from models.arrays import Array
from models.state_space import StateSpaceModel

PASS_SOURCES = (
    *("trajectory.c", "factors.c", "smoother.c", "smoothed_covariance.c", "lagged.c"),
    *("active_set.c", "deadline.c", "one_pass.c"),
)
LAGGED_SOURCES = ("smoothed_covariance.c", "lagged.c")
DESCENT_SOURCES = ("descent.c", "second_start.c")
WINDOW_SOURCES = ("late.c", "slide.c", "window.c")
FUNCTIONS_OF: Mapping[str, tuple[str, ...]] = {
    "CONSTRAINED": ("constrain",),
    "LOSSES": ("measure", "shake"),
}
"""Part of the loop, as C knows it → the generated functions that only it calls."""


def window_loop(
    model: StateSpaceModel,
    config: RealTimeConfig,
    memory: Layout,
    *,
    whole: bool = True,
    clock: int = 0,
) -> Loop:
    """Return the loop of the real-time estimators; see `mhe.realtime`.

    Parameters
    ----------
    memory : see `mhe.window_memory.window_memory`
    whole : with what other models and settings use, so that one compiled loop serves them all;
        False leaves out what this one does not need
    clock : address of a C function that returns seconds; 0 is the machine's own
    """
    scheme = config.scheme
    transition, readings, *small = loop_functions(model)
    window = window_functions(model)
    n_stages, n_c = config.horizon + 1, constraint_rows.count(model)
    most = most_active(n_stages, n_c)
    parts = {
        "CONVERGES": whole or scheme.converges,
        "CONSTRAINED": whole or n_c > 0,
        "LOSSES": whole or config.has_losses,
        "TIMED": whole or config.deadline_s is not None,
        "LAGGED": whole or bool(config.lags),
    }
    left_out = {name for part, names in FUNCTIONS_OF.items() if not parts[part] for name in names}
    needed = [function for function in window if function.name() not in left_out]
    lower, upper = limits(model)
    carry = carry_function(model) if scheme.converges else None
    carried = [] if carry is None else [carry]
    descent = DESCENT_SOURCES if parts["CONVERGES"] else ()
    sources = [name for name in PASS_SOURCES if parts["LAGGED"] or name not in LAGGED_SOURCES]
    return Loop(
        sources=[Path(__file__).with_name(name) for name in (*sources, *descent, *WINDOW_SOURCES)],
        entry="window",
        memory=memory,
        lags=config.lags,
        functions=[transition, readings, *small, *needed, *carried],
        fields={
            "work": workspace(
                model,
                n_stages,
                transition=transition,
                readings=readings,
                most_held=most,
                parts=parts,
                n_lags=len(config.lags),
            ),
            "nnz_F": transition.nnz_out(1),
            "nnz_G": transition.nnz_out(2),
            "nnz_H": readings.nnz_out(1),
            "nnz_L": triangle(model.n_r),
            **{f.name(): f.name() for f in needed},
            **dict.fromkeys(sorted(left_out), NO_FUNCTION),
            "carry": "carry" if carried else NO_FUNCTION,
            "huber": config.thresholds([sensor.name for sensor in model.sensors]),
            "huber_noise": float(config.noise_threshold),
            "has_losses": config.has_losses,
            "n_c": n_c,
            "lower": lower,
            "upper": upper,
            "cost_limits": cost_limits(n_stages, model.n_r),
            "most_active": most,
            "n_lags": len(config.lags),
            "lags": np.array(config.lags, dtype=np.int64),
            "n_derived": len(derived_outputs(model).names),
            "row_conditions": constraint_rows.needs(model),
            "arrival": list(ARRIVAL_COSTS).index(config.arrival_cost),
            "constant_covariance": stored(model.prior),
            "reuse": reuse_threshold(model, config),
            "iterate": scheme.converges,
            "n_stages": n_stages,
            "tolerance": float(scheme.tolerance),
            "most_iterations": int(scheme.max_iterations),
            "deadline": float(np.inf if config.deadline_s is None else config.deadline_s),
            "clock": ctypes.c_void_p(clock),
            **rest_fields(model),
        },
        constants={
            **{f"ARRIVAL_{name}": i for i, name in enumerate(ARRIVAL_COSTS)},
            **({**DESCENT, **SECOND_START} if parts["CONVERGES"] else {}),
            **ACTIVE_SET,
            **FIRST,
            "SETTLED": SETTLED,
            "LEAST_SQUARES": LEAST_SQUARES,
            **rest_constants(model),
            **{part: int(is_in) for part, is_in in parts.items()},
        },
    )


class CompiledWindow(CompiledEngine):
    """The engine of the real-time estimators; see `window_loop`.

    Parameters
    ----------
    clock : for deadlines; None is the machine's own
    """

    def __init__(
        self,
        model: StateSpaceModel,
        config: RealTimeConfig,
        memory: Layout,
        clock: Clock | None = None,
    ) -> None:
        function = None if clock is None else ctypes.CFUNCTYPE(ctypes.c_double)(clock)
        address = 0 if function is None else ctypes.cast(function, ctypes.c_void_p).value or 0
        self._clock = function  # C keeps the address only
        super().__init__(model, window_loop(model, config, memory, clock=address))

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory, result = given.copy(), np.full(self.result.size, np.nan)
        self.call("window_solve", memory, result)
        return memory, result
