"""The filter's state: what it knows of the newest instant, and a log to go back by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimation.estimator import first_state
from estimation.layout import Layout
from estimation.rest import rest_blocks
from estimation.stored import restored, store, stride
from models.arrays import Array, is_whole
from models.errors import InputError
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel

INTERVALS = 4
"""Between the states that are kept: fewer take less room, more are nearer to a late reading."""

FEWEST = 20
"""Rows that a filter reaches back by itself at least."""

MARGIN = 2
"""By how many times it reaches further back than the latest sensor's delay."""


@dataclass(frozen=True, repr=False, eq=False)
class EkfState:
    """The filter after its last measurement, as one flat array; see `filter_memory`."""

    memory: Array
    layout: Layout

    @property
    def time_s(self) -> float | None:
        """Time of the newest instant; None before the first measurement."""
        time_s = self.memory.item(0)
        return None if math.isnan(time_s) else time_s

    @property
    def gaussian(self) -> GaussianState:
        """x_k|k, or the prior x_0|-1."""
        mean = self.layout.view(self.memory, "mean")
        return restored(mean, self.layout.view(self.memory, "covariance"))

    @property
    def seen(self) -> Array:
        """(n_sensors,) 1 for sensors whose readings were used."""
        return self.layout.view(self.memory, "seen")

    @property
    def settling_s(self) -> float:
        """How much longer updates are linearised at their own posterior, s; 0 is not at all."""
        return float(self.layout.view(self.memory, "settling_s"))

    @property
    def doubt(self) -> Array:
        """(2 n_sensors,) per sensor: readings that its gate has rejected in a row, and s since."""
        return self.layout.view(self.memory, "doubt")

    @property
    def inputs(self) -> Array:
        """(n_u,) the last known ones."""
        return self.layout.view(self.memory, "inputs")

    @property
    def rest(self) -> Array:
        """What the detector of rest remembers, see `rest_blocks`; empty where there is none."""
        return self.memory[self.layout.slices["inputs"].stop : self.layout.slices["count"].start]

    @property
    def n_rows(self) -> int:
        """How many rows it can go back by."""
        count = self.layout.view(self.memory, "count")
        return int(count[0]) if len(count) else 0

    def __repr__(self) -> str:
        when = "before the first measurement" if self.time_s is None else f"at {self.time_s:g} s"
        n_x = len(self.layout.view(self.memory, "mean"))
        return f"<EkfState {when}: {n_x} states, back by {self.n_rows} rows>"


@dataclass(frozen=True)
class Kept:
    """How much of the past a state has: ``capacity`` rows, the filter's own every ``spacing``."""

    capacity: int
    spacing: int

    @property
    def checkpoints(self) -> int:
        """How many of the filter's own states."""
        return self.capacity // self.spacing


def check_late_samples(late_samples: int | None) -> None:
    """Raise `InputError` where a filter is asked to go back by less than nothing."""
    if late_samples is not None and not (is_whole(late_samples) and late_samples >= 0):
        raise InputError(f"late_samples is {late_samples!r}, expected a whole number from 0")


def kept_for(model: StateSpaceModel, late_samples: int | None) -> Kept:
    """Return what a setting asks for; see `ekf_baseline.ekf.EkfConfig`.

    A full log forgets up to its next checkpoint, so it is one spacing longer than its reach.
    """
    rows = default_reach(model) if late_samples is None else late_samples
    spacing = max(-(-rows // INTERVALS), 1)
    return Kept(spacing * (-(-rows // spacing) + 1) if rows else 0, spacing)


def default_reach(model: StateSpaceModel) -> int:
    """Return twice the rows that all sensors have within the longest delay, at least 20."""
    longest_s = max((sensor.delay_s for sensor in model.sensors), default=0.0)
    rows = longest_s * sum(sensor.rate_hz or 0.0 for sensor in model.sensors)
    return max(math.ceil(MARGIN * rows), FEWEST)


def filter_memory(model: StateSpaceModel, kept: Kept) -> Layout:
    """Return the layout of the filter's state; ``time_s`` is NaN before the first measurement.

    The blocks from ``count`` on are its log, in order of capture: ``rows`` as they were given,
    ``steps`` between them, s, and the filter's own blocks as they were before every few rows,
    the oldest first. ``times`` begin with that of the state before all rows.
    """
    own = _own_blocks(model)
    size, rows = Layout("Own", own).size, kept.capacity
    log = {
        "count": (min(rows, 1),),
        "times": (rows + min(rows, 1),),
        "steps": (rows,),
        "rows": (rows, model.n_row),
        "checkpoints": (kept.checkpoints, size),
    }
    return Layout("Memory", {**own, **log})


def _own_blocks(model: StateSpaceModel) -> dict[str, tuple[int, ...]]:
    n_x, row = model.n_x, stride(model.n_x)
    state = {
        "time_s": (),
        "mean": (n_x,),
        "covariance": (row, row),
        "seen": (len(model.sensors),),
        "settling_s": (),
        "doubt": (2 * len(model.sensors),),
        "inputs": (model.n_u,),
    }
    return {**state, **rest_blocks(model)}


def first_filter(model: StateSpaceModel, kept: Kept, prior: Prior | None) -> EkfState:
    """Return the state before the first measurement; a prior of None is the model's."""
    layout, gaussian = filter_memory(model, kept), first_state(model, prior)
    memory = np.zeros(layout.size)
    layout.view(memory, "time_s")[...] = np.nan
    layout.view(memory, "mean")[:] = gaussian.mean
    store(gaussian, layout.view(memory, "covariance"))
    layout.view(memory, "inputs")[:] = np.nan
    return EkfState(memory, layout)
