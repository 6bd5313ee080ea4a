"""An export that watches its sensors: estimation/watch/statistics.c and alone.c around its loop."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from types import MappingProxyType

import numpy as np

from estimation.layout import Layout
from estimation.loop import Loop
from estimation.watch.compiled import CONSTANTS, statistics_fields
from estimation.watch.energy import BUSY
from estimation.watch.flags import Flag
from estimation.watch.following import WAIT_S
from estimation.watch.limits import limits_of
from estimation.watch.lost import CALM_S
from estimation.watch.reach import Reach
from estimation.watch.replay import FEWEST_SAMPLES
from estimation.watch.returning import RETURN_S, RETURNS
from estimation.watch.statistics import Statistics
from models.arrays import Array
from models.state_space import StateSpaceModel

SOURCES = ("statistics.c", "alone.c")
ALONE: Mapping[str, float] = MappingProxyType(
    {
        **CONSTANTS,
        **{f"FLAG_{flag.name}": flag.value for flag in Flag},
        "BUSY": BUSY,
        "CALM_S": CALM_S,
        "WAIT_S": WAIT_S,
        "RETURN_S": RETURN_S,
        "RETURNS": RETURNS,
        "FEWEST_SAMPLES": FEWEST_SAMPLES,
    }
)
"""Macros of them."""


@dataclass(frozen=True, eq=False)
class WatchInC:
    """What a watch remembers between two steps.

    Parameters
    ----------
    layout : of all its numbers; ``memory`` is that of `Statistics`, ``known`` and ``lost`` are of
        `Reach`, ``out_s`` says since when each sensor is left out, NaN for one that is not
    start : (layout.size,) before the first measurement
    instants : where times stand among them
    """

    layout: Layout
    start: Array
    instants: tuple[slice, ...]


def watched_loop(model: StateSpaceModel, loop: Loop) -> tuple[Loop, WatchInC]:
    """Return a loop with the watch behind it, and what that remembers."""
    statistics, reach = Statistics(model, limits_of(model)), Reach(model)
    is_asked = np.isin(np.arange(model.n_x), reach.components)
    layout = Layout(
        "Alone",
        {
            "memory": (statistics.layout.size,),
            "known": (model.n_x,),
            "lost": (),
            "out_s": (statistics.n_sensors,),
            "begun_s": (),
            "alarm_s": (),
        },
    )
    start = np.zeros(layout.size)
    layout.view(start, "memory")[:] = statistics.first()
    layout.view(start, "known")[:] = is_asked & (model.prior.std < reach.found)
    for block in ("out_s", "begun_s", "alarm_s"):
        layout.view(start, block)[...] = np.nan
    fields = {
        "watch": statistics.layout,
        **statistics_fields(statistics),
        "found_std": np.where(is_asked, reach.found, np.nan),
        "lost_std": np.where(is_asked, reach.lost, np.nan),
    }
    folder = Path(str(resources.files("estimation.watch")))
    watched = dataclasses.replace(
        loop,
        sources=[*loop.sources, *(folder / name for name in SOURCES)],
        fields={**loop.fields, "statistics": fields, "alone": layout},
        constants={**loop.constants, **ALONE},
    )
    repeated = statistics.layout.slices["repeated_s"]
    times = (layout.slices[block] for block in ("out_s", "begun_s", "alarm_s"))
    return watched, WatchInC(layout, start, (repeated, *times))
