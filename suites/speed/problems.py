"""The problems of the suite, as data: a model, a recording to cut windows from, a horizon.

A problem's name is that of its model; with its horizon it makes the key ``pen15_20``
under which results and files go. Every problem is there twice: as it is, and with the
bounds of its body (``pen15_20_bounded``) on the same recording.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from benchmark.bodies import BODIES, BoundedBody
from models.names import unknown
from models.state_space import StateSpaceModel

DURATION_S = 12.0
"""Of a problem's recording: fixed, so that the first windows are the same in any number."""
BOUNDED = "_bounded"
"""At the end of a bounded problem's key."""


@dataclass(frozen=True)
class Problem:
    """Windows of one length from one recording.

    Parameters
    ----------
    name : a key of `BODIES`
    horizon : N, intervals of a window
    windows : how many are timed; more narrows the median and takes longer
    seed : of the recording
    bounded : whether the bounds of its body hold
    """

    name: str
    horizon: int
    windows: int
    seed: int = 0
    bounded: bool = False

    @property
    def key(self) -> str:
        """Name and horizon: ``pen15_20``, ``pen15_20_bounded``."""
        return f"{self.name}_{self.horizon}{BOUNDED if self.bounded else ''}"

    @property
    def body(self) -> BoundedBody:
        """What moves."""
        return BODIES[self.name]()

    @property
    def model(self) -> StateSpaceModel:
        """The state-space model, with its bounds where the problem is bounded."""
        body = self.body
        model = body.model()
        return model.bounded(**body.bounds) if self.bounded else model


FREE: tuple[Problem, ...] = (
    Problem("turntable", 20, 200),
    Problem("pen15", 20, 200),
    Problem("pen15", 100, 60),
    Problem("pen15", 500, 20),
    Problem("pen24", 20, 200),
    Problem("pen24", 60, 60),
)
"""The problems without bounds."""

PROBLEMS: tuple[Problem, ...] = (*FREE, *(replace(problem, bounded=True) for problem in FREE))
"""The suite."""


def find_problem(key: str) -> Problem:
    """Return a problem by its key; raises `InputError` for an unknown one."""
    for problem in PROBLEMS:
        if problem.key == key:
            return problem
    raise unknown("problem", key, (problem.key for problem in PROBLEMS))
