"""What windows of suite `optimum` are cut from, and the table of suites that lend some of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from types import MappingProxyType

import numpy as np

from estimation.recording import Recording
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel

Recorded = tuple[Recording, GaussianState]
"""A recording, and the prior of its first state."""


@dataclass(frozen=True, eq=False)
class WindowBody:
    """A model, how to record something of it, and the windows that make sense of it.

    Parameters
    ----------
    model : what estimators are told
    step_s : between the instants of its fastest sensor
    record : kind of window, least duration (s) and generator → what is recorded
    kinds : names of kinds of windows, see `suites.optimum.kinds`
    horizons : kind → N of one window after the other; without it those of the table
    before_s : (shortest, longest) time before a window, s, instead of its kind's
    """

    model: StateSpaceModel
    step_s: float
    record: Callable[[str, float, np.random.Generator], Recorded]
    kinds: tuple[str, ...]
    horizons: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    before_s: tuple[float, float] | None = None


LENDERS = ("suites.gyro_free.windows", "suites.classics.windows")
"""Modules whose ``window_bodies`` returns bodies by name."""


def lent_bodies() -> Mapping[str, WindowBody]:
    """Return the bodies of all lenders by name, in their order."""
    found: dict[str, WindowBody] = {}
    for module in LENDERS:
        found |= import_module(module).window_bodies()
    return MappingProxyType(found)
