"""The window's loop in C, around a model's generated functions."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np

from estimation.engine import CompiledEngine, Loop
from estimation.kalman_stage import stage_functions
from estimation.layout import Layout
from mhe.arrival_cost import ARRIVAL_COSTS, RELINEARISATION_LIMIT
from mhe.config import MheConfig
from mhe.descent import DESCENT
from mhe.stage_functions import window_functions
from models.arrays import Array
from models.state_space import StateSpaceModel

SOURCES = ("pass.c", "descent.c", "window.c")


class CompiledWindow(CompiledEngine):
    """The engine of the real-time estimators; see `mhe.realtime`.

    Parameters
    ----------
    iterates : passes to convergence, or one pass a sample
    """

    def __init__(
        self, model: StateSpaceModel, config: MheConfig, memory: Layout, iterates: bool
    ) -> None:
        stage = stage_functions(model)
        predict, update, *small = stage
        window = window_functions(model, predict, update)
        loop = Loop(
            sources=[Path(__file__).with_name(name) for name in SOURCES],
            entry="window",
            memory=memory,
            functions=[[predict], [update], small, window],
            fields={
                "work": _work(model, config.horizon + 1, predict, update),
                "nnz_F": predict.nnz_out("F"),
                "nnz_G": predict.nnz_out("G"),
                "nnz_H": update.nnz_out("H"),
                "nnz_L": update.nnz_out("L"),
                **{f.name(): f.name() for f in window},
                "huber": config.thresholds([sensor.name for sensor in model.sensors]),
                "huber_noise": float(config.noise_threshold),
                "has_losses": config.has_losses,
                "arrival": list(ARRIVAL_COSTS).index(config.arrival_cost),
                "constant_covariance": np.asarray(model.prior.covariance, dtype=float),
                "relinearisation_limit": RELINEARISATION_LIMIT,
                "iterate": iterates,
                "n_stages": int(config.horizon) + 1,
                "tolerance": float(config.tolerance),
                "most_iterations": int(config.max_iterations),
                "most_seconds": float(np.inf if config.max_time_s is None else config.max_time_s),
                "nothing": np.full(model.n_y, np.nan),
            },
            constants={
                **{f"ARRIVAL_{name}": i for i, name in enumerate(ARRIVAL_COSTS)},
                **DESCENT,
            },
        )
        super().__init__(model, loop)

    def solve(self, given: Array) -> tuple[Array, Array]:
        """Converge on a window as it stands; return it solved, and the result."""
        memory, result = given.copy(), np.full(self.result.size, np.nan)
        self.call("window_solve", memory, result)
        return memory, result


def _work(
    model: StateSpaceModel, n_stages: int, predict: ca.Function, update: ca.Function
) -> dict[str, Array]:
    """Return the workspace: arrays with one entry per stage, single ones, and vectors (μ, w)."""
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    stages = {
        "d_plus": n_x,
        "P_plus": n_x * n_x,
        "W": n_x * n_r,
        "e": n_r,
        "H": update.nnz_out("H"),
        "L": update.nnz_out("L"),
        "F": predict.nnz_out("F"),
        "G": predict.nnz_out("G"),
        "d_s": n_x,
        "x_try": n_x,
        "row_scale": n_r,
        "row_scale_try": n_r,
        "noise_scale": n_w,
        "noise_scale_try": n_w,
    }
    single = {
        "reached": n_x,
        "defect": n_x,
        "d_minus": n_x,
        "P_minus": n_x * n_x,
        "v": n_r,
        "S": n_r * n_r,
        "lambda": n_x,
        "lambda_hat": n_x,
        "spread": n_x,
        "d": n_x,
        "d_try": n_x,
        "L_prior": n_x * n_x,
        "no_noise": n_w,
    }
    vectors = ("z", "g", "z_1", "g_1", "z_2", "g_2", "z_next", "g_next", "z_try", "f", "f_1", "f_2")
    return {
        **{name: np.zeros(n_stages * width) for name, width in stages.items()},
        **{name: np.zeros(width) for name, width in single.items()},
        **{name: np.zeros(n_x + n_stages * n_w) for name in vectors},
        "unit_noises": np.ones(n_stages * n_w),
    }
