"""The flat array that holds a window between two steps, and how to look into it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimation.estimator import first_state
from estimation.kalman_stage import rows_present, without_gaps
from estimation.layout import Layout
from estimation.recording import Measurement
from estimation.rest import rest_blocks
from estimation.stored import restored, store, stored, stride
from mhe import constraint_rows
from mhe.arrival_cost import diffuse
from mhe.config import WindowConfig
from mhe.late import sensors_there
from mhe.trajectory import Trajectory
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class WindowState:
    """The window after the last measurement, as one flat array; see `window_memory`."""

    memory: Array


def window_memory(model: StateSpaceModel, n_stages: int) -> Layout:
    """Return the layout of a window: stages oldest first, `count` of them.

    ``x_lin`` and ``w_lin`` are what the last pass was linearised at, ``moved`` how far
    the stage is from there, squared (`mhe.reuse`), ``active`` and ``demanded`` marks of the rows of
    `mhe.constraint_rows`. ``costate`` is λ̂ that smoothed each stage, ``away`` how far later
    readings would have moved it, ``length`` its share of the squared length of the last step;
    the first ``stayed`` stages have the factors that they were smoothed with. ``wait`` is how many
    samples the next second start waits (`mhe.second_start`). ``apart`` is 1 where a late reading
    stands between two states that do not follow from each other yet (`mhe.late`). ``seen`` is 1 for
    sensors that ever had a reading.
    ``prior_deviation`` is that of the prior's mean from ``x_lin``, ``predicted`` x_k|k-1 of each
    stage when it was the newest, ``newest_mean`` and ``newest_covariance`` the last estimate,
    ``inputs`` the last known ones, NaN before the first measurement.
    """
    n_x, n_w, n_c = model.n_x, model.n_w, constraint_rows.count(model)
    row = stride(n_x)
    return Layout(
        "Memory",
        {
            "count": (),
            "times": (n_stages,),
            "y": (n_stages, model.n_row),
            "present": (n_stages, model.n_r),
            "x": (n_stages, n_x),
            "w": (n_stages - 1, n_w),
            "x_lin": (n_stages, n_x),
            "w_lin": (n_stages - 1, n_w),
            "moved": (n_stages,),
            "costate": (n_stages, n_x),
            "away": (n_stages,),
            "length": (n_stages,),
            "stayed": (),
            "wait": (),
            "apart": (),
            "seen": (len(model.sensors),),
            "active": (n_stages, n_c),
            "demanded": (n_stages, n_c),
            "predicted": (n_stages, n_x),
            "prior_mean": (n_x,),
            "prior_covariance": (row, row),
            "prior_deviation": (n_x,),
            "newest_mean": (n_x,),
            "newest_covariance": (row, row),
            "inputs": (model.n_u,),
            **rest_blocks(model),
        },
    )


def packed_window(
    model: StateSpaceModel,
    n_stages: int,
    prior: GaussianState,
    measurements: Sequence[Measurement],
    trajectory: Trajectory,
) -> WindowState:
    """Return the state whose window holds some measurements and a trajectory.

    Parameters
    ----------
    prior : of the first stage, given all measurements before it
    measurements : at most `n_stages`
    """
    layout, count = window_memory(model, n_stages), len(measurements)
    memory = np.zeros(layout.size)
    states, noises = trajectory.states, trajectory.noises
    per_stage: dict[str, Any] = {
        "times": [m.time_s for m in measurements],
        "y": [without_gaps(m.y) for m in measurements],
        "present": [rows_present(model, m.y) for m in measurements],
        "demanded": [constraint_rows.demanded(model, m.y) for m in measurements],
        "x": states,
        "x_lin": states,
        "moved": np.inf,  # nothing has factors yet
        "predicted": states,
    }
    for block, value in per_stage.items():
        layout.view(memory, block)[:count] = value
    whole: dict[str, Any] = {
        "count": count,
        "seen": sensors_there(model, np.any(per_stage["present"], axis=0)),
        "prior_mean": prior.mean,
        "prior_covariance": stored(prior),
        "prior_deviation": -np.asarray(model.difference(states[0], prior.mean)).ravel(),
        "newest_mean": states[-1],
        "newest_covariance": stored(prior),
        "inputs": measurements[-1].y[model.n_y :],
    }
    for block, value in whole.items():
        layout.view(memory, block)[...] = value
    for block in ("w", "w_lin"):
        layout.view(memory, block)[: count - 1] = noises
    return WindowState(memory)


def first_window(
    model: StateSpaceModel, config: WindowConfig, memory: Layout, prior: Prior | None
) -> WindowState:
    """Return the state before the first measurement; a prior of None is the model's."""
    prior = first_state(model, prior)
    if config.arrival_cost == "none":
        prior = diffuse(prior)
    state = np.zeros(memory.size)
    memory.view(state, "inputs")[:] = np.nan
    for part in ("prior", "newest"):
        put(memory, state, part, prior)
    return WindowState(state)


def put(layout: Layout, memory: Array, part: str, gaussian: GaussianState) -> None:
    """Write a Gaussian as the window's ``prior`` or ``newest``."""
    layout.view(memory, f"{part}_mean")[:] = gaussian.mean
    store(gaussian, layout.view(memory, f"{part}_covariance"))


PER_STAGE = (
    *("times", "y", "present", "x", "x_lin", "moved", "costate", "away", "length"),
    *("active", "demanded", "predicted"),
)


BETWEEN_STAGES = ("w", "w_lin")


WHOLE = ("stayed", "wait", "apart", "seen", "prior_deviation")


@dataclass(frozen=True, eq=False)
class View:
    """The stages of a window's flat array, as views: see `mhe.window_memory.window_memory`.

    `told` is the stage of the measurement that the step was given.
    """

    times: Array
    y: Array
    present: Array
    x: Array
    x_lin: Array
    moved: Array
    costate: Array
    away: Array
    length: Array
    active: Array
    demanded: Array
    predicted: Array
    w: Array
    w_lin: Array
    stayed: Array
    wait: Array
    apart: Array
    seen: Array
    prior: GaussianState
    prior_deviation: Array
    newest: GaussianState
    told: int

    @classmethod
    def of(cls, layout: Layout, memory: Array, *, told: int | None = None) -> View:
        """Look at as many stages as the window has; by default the newest is told of."""
        count = int(layout.view(memory, "count"))
        stages = {block: layout.view(memory, block)[:count] for block in PER_STAGE}
        for block in BETWEEN_STAGES:
            stages[block] = layout.view(memory, block)[: max(count - 1, 0)]
        prior, newest = (
            restored(layout.view(memory, f"{part}_mean"), layout.view(memory, f"{part}_covariance"))
            for part in ("prior", "newest")
        )
        whole = {block: layout.view(memory, block) for block in WHOLE}
        at = count - 1 if told is None else told
        return cls(**stages, **whole, prior=prior, newest=newest, told=at)


@dataclass(frozen=True, eq=False)
class Scales:
    """Scales of the rows (n, n_r) and the noises (n - 1, n_w) by which losses weigh them."""

    rows: Array
    noises: Array
