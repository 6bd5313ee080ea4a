"""Linearised windows as arguments of a pass, at trajectories that obey nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.kalman_stage import rows_present, without_gaps
from estimation.recording import Measurement
from mhe.constraint_rows import count, demanded
from mhe.sparse_qp.osqp_window import OsqpWindow, QpSolution
from mhe.window_memory import Scales, View, window_memory
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.linear_models import constant_acceleration_system


@dataclass(frozen=True, eq=False)
class Linearised:
    """The arguments of a pass."""

    view: View
    d: Array
    scales: Scales
    demanded: NDArray[np.bool_]


def linearised(
    model: StateSpaceModel,
    measurements: list[Measurement],
    seed: int,
    off: float = 1.0,
    noise_scale: float = 1.0,
    row_scale: float = 1.0,
) -> Linearised:
    """A window at a trajectory that is drawn anywhere near the prior, and obeys nothing.

    Parameters
    ----------
    off : how far the trajectory is, in standard deviations of the prior
    noise_scale, row_scale : largest of the losses' scales, and their smallest for rows
    """
    rng, n, layout = np.random.default_rng(seed), len(measurements), window_memory
    memory = layout(model, n)
    flat = np.zeros(memory.size)
    memory.view(flat, "count")[...] = n
    view = View.of(memory, flat)
    view.times[:] = [m.time_s for m in measurements]
    view.y[:] = [without_gaps(m.y) for m in measurements]
    view.present[:] = [rows_present(model, m.y) for m in measurements]
    asked = np.array([demanded(model, m.y) for m in measurements]).reshape(n, count(model))
    view.demanded[:] = asked
    view.prior.mean[:], view.prior.covariance[:] = model.prior.mean, model.prior.covariance
    view.x[:] = model.prior.mean + off * model.prior.std * rng.uniform(-1, 1, (n, model.n_x))
    view.w[:] = off * rng.standard_normal((n - 1, model.n_w))
    d = np.asarray(model.difference(view.x[0], model.prior.mean)).ravel()
    rows = view.present * rng.uniform(row_scale, 1, view.present.shape)
    noises = rng.uniform(1, noise_scale, view.w.shape)
    return Linearised(view, d, Scales(rows, noises), asked)


def run(window: Linearised, osqp: OsqpWindow) -> QpSolution:
    return osqp.run(window.view, window.d, window.scales, window.demanded)


def bounded_stream(n: int) -> tuple[StateSpaceModel, list[Measurement]]:
    """A linear system with even steps and nothing missing: all windows have the same slopes."""
    system = constant_acceleration_system(2)
    rng = np.random.default_rng(8)
    measurements = system.simulate(0.125 * np.arange(n), rng, missing=0.0)
    lowest = min(m.y[0] for m in measurements)
    return system.model.bounded(s0_m=(-np.inf, lowest)), measurements
