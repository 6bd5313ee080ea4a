"""The cases: what is measured on which stream, in one race."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from benchmark.tasks.task import Outcome
from suites.real_time import late_times, reuse, sample_times
from suites.real_time.deadlines import DEADLINES, KINDS, deadline_race
from suites.real_time.streams import STREAMS, Stream


@dataclass(frozen=True)
class TimedCase:
    """One race.

    Parameters
    ----------
    stream : a key of `STREAMS`
    contenders : their names
    race : a stream → what each of them found
    """

    stream: str
    contenders: Sequence[str]
    race: Callable[[Stream], Mapping[str, Outcome]]

    @property
    def is_real(self) -> bool:
        """Whether it needs a recording."""
        return STREAMS[self.stream].is_real


def reuse_case(stream: str, horizon: int) -> str:
    """Return the name of the case in which factors are kept along a stream."""
    return f"{stream}_{horizon}"


def deadline_case(deadline: str) -> str:
    """Return the name of the case with a deadline."""
    return f"deadline_{deadline}"


DEADLINE_STREAM, RECORDED_STREAM = "pen24", "dpoint-30"
INSTANTS, LATE = f"{RECORDED_STREAM}_instants", f"{RECORDED_STREAM}_late"

CASES: Mapping[str, TimedCase] = MappingProxyType(
    {
        **{
            reuse_case(name, N): TimedCase(
                name, tuple(reuse.CONTENDERS), partial(reuse.reuse_race, horizon=N)
            )
            for name in STREAMS
            for N in reuse.HORIZONS
        },
        **{
            deadline_case(name): TimedCase(
                DEADLINE_STREAM, KINDS, partial(deadline_race, deadline=deadline)
            )
            for name, deadline in DEADLINES.items()
        },
        INSTANTS: TimedCase(
            RECORDED_STREAM, tuple(sample_times.CONTENDERS), sample_times.time_race
        ),
        LATE: TimedCase(RECORDED_STREAM, tuple(late_times.CONTENDERS), late_times.late_race),
    }
)
"""Case → its race."""
