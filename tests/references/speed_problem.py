"""Reads a problem file of the suite speed with NumPy alone, and computes its costs.

Knows nothing of this project but the description of the file: the pen without spin, its
accelerometer at a place d, its gyroscope. Rigid-body kinematics in body axes,

    f = B (a + (0, 0, g)) + ω̇ × d + ω × (ω × d),     ω = (-cosθ ωφ, -ωθ, sinθ ωφ).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


def body_readings(x: Array, file: Any) -> Array:
    """h(x): what accelerometer and gyroscope read, (n_y,)."""
    azimuth, elevation = x[3:5]
    rate_a, rate_e, acc_a, acc_e = x[8], x[9], x[13], x[14]
    s, c, sin_a, cos_a = np.sin(elevation), np.cos(elevation), np.sin(azimuth), np.cos(azimuth)
    B = np.array([[s * cos_a, s * sin_a, -c], [-sin_a, cos_a, 0], [c * cos_a, c * sin_a, s]])
    w = np.array([-c * rate_a, -rate_e, s * rate_a])
    w_dot = np.array([s * rate_e * rate_a - c * acc_a, -acc_e, c * rate_e * rate_a + s * acc_a])
    d = file["accel_position_m"]
    up = np.array([0, 0, float(file["gravity_m_s2"])])
    force = B @ (x[10:13] + up) + np.cross(w_dot, d) + np.cross(w, np.cross(w, d))
    readings = []
    for name, vector in (("accel", force), ("gyro", w)):
        in_sensor_axes = file[f"{name}_sensor_to_body"].T @ vector
        readings.append(in_sensor_axes[file[f"{name}_axes"]])
    return np.concatenate(readings)


def cost(file: Any, window: int, start: Array, noises: Array) -> float:
    """½ the sum of squares of a window at a first state and unit noises."""
    y, present = file["y"][window], file["present"][window]
    F, G = (file[name][file["step_index"][window]] for name in "FG")
    away = start - file["prior_mean"][window]
    total, x = away @ np.linalg.solve(file["prior_covariance"][window], away), start
    for k in range(len(y)):
        if k:
            x = F[k - 1] @ x + G[k - 1] @ noises[k - 1]
        residual = (y[k] - body_readings(x, file)) / file["noise_std"]
        total += np.sum(residual[present[k]] ** 2)
    return float(total + np.sum(noises**2)) / 2


def costs_of_solutions(path: Path) -> tuple[Array, Array]:
    """Stored costs, and those computed from the stored solutions, (windows,)."""
    with np.load(path) as file:
        states, noises = file["solution_states"], file["solution_noises"]
        computed = [cost(file, i, states[i, 0], noises[i]) for i in range(len(states))]
        return file["cost"], np.array(computed)
