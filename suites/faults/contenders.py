"""Who is judged: estimators with a watch around them, and some without it to compare with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.from_mhe import REFERENCE
from estimation.watch.watched import Watched
from suites.faults.cells import Bench, Wrap, bare, bench_of

SEEDS = 10
"""Of the full table; fewer show a part of it."""
IN_PART = "ekf"
"""The estimator that is shown then."""


@dataclass(frozen=True)
class FaultContender:
    """An estimator as the suite runs it.

    Parameters
    ----------
    estimator : of `suites.faults.protocol.ESTIMATORS`
    is_watched : whether with a watch
    most_seeds : on so many it runs at most
    in_part : whether it runs where only a part of the table is shown
    is_judged_clean : whether it runs on fault-free streams, too
    """

    estimator: str
    is_watched: bool = True
    most_seeds: int = SEEDS
    in_part: bool = False
    is_judged_clean: bool = True

    @property
    def wrap(self) -> Wrap:
        """What is put around the estimator."""
        return Watched if self.is_watched else bare

    def bench(self, sensors: str) -> Bench:
        """Return its bench, built once."""
        return bench_of(self.estimator, sensors, self.wrap)


def without_watch(estimator: str) -> str:
    """Return the name of an estimator without a watch."""
    return f"{estimator}-unwatched"


CONTENDERS: Mapping[str, FaultContender] = MappingProxyType(
    {
        REFERENCE: FaultContender(REFERENCE, most_seeds=1, is_judged_clean=False),
        **{
            name: FaultContender(name, in_part=name == IN_PART)
            for name in reversed(BENCHMARK_ESTIMATORS)
        },
        **{
            without_watch(name): FaultContender(
                name, is_watched=False, most_seeds=3, in_part=name == IN_PART, is_judged_clean=False
            )
            for name in reversed(BENCHMARK_ESTIMATORS)
        },
    }
)
"""Name → contender, the slow ones first."""
