"""The workspace of the window's loop in C: what it keeps between passes, and room to work in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from estimation.linearisation import triangle
from estimation.stored import stride
from mhe import constraint_rows
from models.state_space import StateSpaceModel


def workspace(
    model: StateSpaceModel,
    n_stages: int,
    *,
    transition: ca.Function,
    readings: ca.Function,
    most_held: int,
    parts: Mapping[str, bool],
    n_lags: int,
) -> Mapping[str, Any]:
    """Return the workspace: arrays with one entry per stage or row, and single ones."""
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    n_c, row = constraint_rows.count(model), stride(n_x)
    n_rows, converges = n_stages * n_c, parts["CONVERGES"]
    per_stage = {
        "at_time": 1,
        "at_x": n_x,
        "at_y": model.n_row,
        "at_rows": n_r,
        "at_w": n_w,
        "at_noises": n_w,
        "d_minus": n_x,
        "d_plus": n_x,
        "P_plus": row * row,
        "W": row * n_r,
        "e": n_r,
        "H": readings.nnz_out(1),
        "L": triangle(n_r),
        "F": transition.nnz_out(1),
        "G": transition.nnz_out(2),
        "d_s": n_x,
        "expected": n_r,
        "row_scale": n_r,
        "noise_scale": n_w,
    }
    single = {
        **dict.fromkeys(("reached", "defect", "lambda", "lambda_hat", "spread", "shift"), n_x),
        **dict.fromkeys(("d_minus_prior", "d_prior", "x_prior"), n_x),
        **dict.fromkeys(("P_prior", "P_first", "P_minus"), row * row),
        **dict.fromkeys(("J", "JP"), n_x * n_x if converges else 0),
        "d_carried": n_x if converges else 0,
        "v": n_r,
        "S": n_r * n_r,
        "no_noise": n_w,
        "nothing_present": n_r,
        "row": model.n_row,
        "joined": model.n_row,
        "late_rows": n_r,
        "w_late": n_w,
        "reused": 1,
        "pass_time": 3,
        "violation": n_c,
        "g": n_x + n_stages * n_w,
    }
    constrained = {
        **dict.fromkeys(("d_shift", "impulse"), n_stages * n_x),
        "e_shift": n_stages * n_r,
        "d_pushed": n_x,
        "e_pushed": n_r,
        "row_try": n_c,
        **dict.fromkeys(("row_g", "row_free", "row_value", "row_std", "is_held"), n_rows),
        **dict.fromkeys(("row_e", "row_std_held", "row_multiplier"), n_rows if converges else 0),
        **dict.fromkeys(("row_C", "row_PC"), n_rows * n_x),
        "response": (most_held + 1) * n_rows,
        "set_factor": (most_held + 1) * most_held,
        **dict.fromkeys(("multiplier", "step"), most_held + 1),
    }
    vectors = ("z", "z_1", "g_1", "z_2", "g_2", "z_next", "g_next", "z_try", "f", "f_1", "f_2")
    converging = {
        **dict.fromkeys(vectors, n_x + n_stages * n_w),
        "x_try": n_stages * n_x,
        "row_scale_try": n_stages * n_r,
        "noise_scale_try": n_stages * n_w,
        **dict.fromkeys(("d", "d_try", "deviation"), n_x),
        "L_prior": n_x * n_x,
        **dict.fromkeys(("violation_try", "weight"), n_c),
        "x_first": n_stages * n_x,
        "w_first": n_stages * n_w,
        "active_first": n_rows,
        "apart_first": 1,
        "P_newest": row * row,
        "v_first": n_r,
        "S_first": n_r * n_r,
    }
    rows = stride(n_r)
    lagged = {
        "x_lagged": n_lags * n_x,
        "P_lagged": n_lags * n_x * n_x,
        **dict.fromkeys(("costates", "square", "turned", "P_told"), row * row),
        "rows_lagged": rows * (3 * row + rows),
    }
    sizes = {
        **{name: n_stages * width for name, width in per_stage.items()},
        **single,
        **(constrained if n_c else dict.fromkeys(constrained, 0)),
        **(converging if converges else {}),
        **(lagged if parts["LAGGED"] else {}),
    }
    return {
        **{name: np.zeros(size) for name, size in sizes.items()},
        "ring": np.zeros(2, dtype=np.int64),
        **({"rows_there": np.zeros(n_r, dtype=np.int64)} if parts["LAGGED"] else {}),
        "told": np.zeros(1, dtype=np.int64),
        "set": np.zeros(most_held + 1, dtype=np.int64),
        "unit_noises": np.ones(n_stages * n_w),
    }
