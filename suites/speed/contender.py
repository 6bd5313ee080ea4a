"""What a contender is: something that is built once and then solves one item after the other.

An item is a window (`suites.speed.windows.SpeedWindow`) for what optimises, a sample
(`suites.speed.samples.Sample`) for what filters. Whatever a contender needs in its own
form is made in `prepare`, which is not timed; `solve` is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from mhe.trajectory import Trajectory
from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.peers import (
    ContenderAbsentError as ContenderAbsentError,
)  # all three are looked for here
from suites.peers import in_silence as in_silence
from suites.peers import peer as peer
from suites.speed.clock import Counted

ItemT = TypeVar("ItemT")
ItemIn = TypeVar("ItemIn", contravariant=True)

ONE_PASS, CONVERGED = "one pass", "converged"
PASS_CALL, CONVERGED_CALL = "one pass, compiled call", "converged, compiled call"
COLD_CALL = "one pass, compiled call, cold caches"
STEP, OVERHEAD, BATCH = "step", "step overhead", "batch"
STREAM_CALL, FULL_STREAM_CALL = "stream, compiled call", "stream, compiled call, full passes"
EXPORTED, EXPORTED_FLOAT = "step, exported C", "step, exported C, float"
BUFFERS, ALGEBRA = "step, compiled callbacks", "step, algebra only"
"""Modes: what is done with an item, or which part of it is timed."""


@dataclass(frozen=True, eq=False)
class RaceOutcome:
    """What a contender makes of an item.

    Parameters
    ----------
    solved : fraction of the item that it calls solved, 0 or 1 for a single one
    newest : (n_x,) its newest state
    trajectory : the window's states and noises; None for a filter
    """

    solved: float
    newest: Array
    trajectory: Trajectory | None = None


class Contender(Protocol[ItemIn]):
    """One contender, built for one problem."""

    version: str

    def prepare(self, item: ItemIn) -> None:
        """Bring an item into the contender's own form; may be called again for the same item."""

    def solve(self) -> Counted | None:
        """Do the work; timed. Return what to count instead of all of it, or None."""

    def outcome(self) -> RaceOutcome:
        """Return what the last `solve` found; it ends the turn."""


@dataclass(frozen=True)
class Entry(Generic[ItemT]):
    """A contender's row in a table.

    Parameters
    ----------
    name : of the contender
    mode : what it does with an item
    build : model and a first item → the contender; raises `ContenderAbsentError`
    samples : samples that one call of `solve` takes; times are divided by it
    horizon : N, where it is not the problem's
    judged : whether its newest state is to be that of the reference
    is_cold : whether the processor has forgotten it before every call, as it may between the
        samples of a live sensor
    """

    name: str
    mode: str
    build: Callable[[StateSpaceModel, ItemT], Contender[ItemT]]
    samples: int = 1
    horizon: int | None = None
    judged: bool = True
    is_cold: bool = False

    @property
    def label(self) -> str:
        """Name and mode, for people."""
        return f"{self.name} ({self.mode})"


def knows_only_bounds(model: StateSpaceModel) -> None:
    """Raise `ContenderAbsentError` where a model has inequalities beside its bounds."""
    if model.inequality.numel_out(0):
        raise ContenderAbsentError("its problem is written down here with bounds only")
