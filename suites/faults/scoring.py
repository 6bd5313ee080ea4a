"""How a run with a fault is scored, by the definitions at the top of ``faults.toml``.

An instant stands until the next one. Wrong is an instant at which any judged quantity is more
claimed deviations off than its limit; silent one at which nothing is said that the fault-free run
never says. A silent wrong answer is more than `SILENT_S` of both, all such instants together.
After a fault's end estimates are right again at the begin of the first window of `RIGHT_FOR_S` that
is right; a fault that stays has no end, and they must be right from within it to the recording's.
One instant that is off but not wrong is allowed there, however few there are: at 1 Hz, of 6
quantities at 5 instants one is beyond 3 deviations in 8 % of the runs where every claim is true.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.history import EstimateHistory
from models.arrays import Array
from suites.faults.protocol import ANGLES, TIP
from suites.faults.said import Said
from suites.faults.table import INSTANT_S, Fault

WRONG_STDS, OF_CLEAN = 5.0, 1.5
SILENT_S = 0.2
RIGHT_STDS, MOST_OFF, RIGHT_FOR_S = 3.0, 0.05, 0.3
SLACK_DEG, SLACK_MM = 0.3, 0.5
SETTLED_S = 1.0
"""Begin of a fault-free run that its RMS errors leave out."""


@dataclass(frozen=True, eq=False)
class RunErrors:
    """Errors of a run's judged quantities against the truth.

    Parameters
    ----------
    names : (k,)
    time_s : (n,)
    errors : (n, k) rad and m, infinite where the estimate is no number
    stds : (n, k) errors in claimed deviations, their size
    told : what was said
    step_time_s : (n,)
    """

    names: tuple[str, ...]
    time_s: Array
    errors: Array
    stds: Array
    told: Said
    step_time_s: Array

    @classmethod
    def of(
        cls, history: EstimateHistory, names: tuple[str, ...], truth: Mapping[str, Array]
    ) -> RunErrors:
        """Return the errors of a history.

        Parameters
        ----------
        truth : name → (n,) at the instants of the history
        """
        errors = np.column_stack([history.column(name) - truth[name] for name in names])
        is_angle = np.array([name in ANGLES for name in names])
        errors[:, is_angle] = np.remainder(errors[:, is_angle] + np.pi, 2 * np.pi) - np.pi
        claimed = np.column_stack([history.std_of(name) for name in names])
        errors[~np.isfinite(errors)] = np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            stds = np.abs(errors) / claimed
        stds[~np.isfinite(stds)] = np.inf
        return cls(names, history.time_s, errors, stds, Said.of(history), history.step_time_s)

    @property
    def lasting_s(self) -> Array:
        """(n,) how long each instant stands: until the next; the last as long as most do."""
        steps = np.maximum(np.diff(self.time_s), 0.0)
        return np.append(steps, np.median(steps) if len(steps) else 0.0)

    @property
    def attitude_deg(self) -> Array:
        """(n,) length of the error of the judged angles, deg."""
        return np.degrees(self._length(ANGLES))

    @property
    def tip_mm(self) -> Array:
        """(n,) length of the error of the tip, mm; 0 where it is not judged."""
        return 1e3 * self._length(TIP)

    def _length(self, of: tuple[str, ...]) -> Array:
        part = self.errors[:, [name in of for name in self.names]]
        with np.errstate(over="ignore"):
            return np.asarray(np.sqrt((part**2).sum(axis=1)))


@dataclass(frozen=True)
class FaultScore:
    """A run with a fault beside the same run without.

    Parameters
    ----------
    silent_s, wrong_s : seconds of wrong answers, those that nothing was said of and all
    right_s, accurate_s : from the fault's end (its begin, where it stays) until estimates are
        right again, by their claims and by their errors; infinite where they never are
    peak_stds, peak_deg, peak_mm : largest errors from the fault's begin on
    told_s : seconds in which something was said that the fault-free run never says
    flagged_s : seconds in which a sensor was flagged
    false_flags, false_flagged_s : of the fault-free run: times that a flag went up, and seconds
        in which one was up
    said : words, with how long each was said
    broke : why the run broke off; empty where it did not
    is_finite : whether every estimate is a number
    """

    silent_s: float
    wrong_s: float
    right_s: float
    accurate_s: float
    peak_stds: float
    peak_deg: float
    peak_mm: float
    told_s: float
    flagged_s: float
    false_flags: int
    false_flagged_s: float
    said: str = ""
    broke: str = ""
    is_finite: bool = True

    @property
    def is_silent_wrong(self) -> bool:
        """Whether it is a silent wrong answer, as a run that broke off is."""
        return self.silent_s > SILENT_S + INSTANT_S


def score(errors: RunErrors, clean: RunErrors, fault: Fault) -> FaultScore:
    """Return the score of a run with a fault.

    Parameters
    ----------
    clean : of the same run without the fault
    """
    lasting_s, told = errors.lasting_s, errors.told.more_than(clean.told)
    wrong = (errors.stds > limits(clean)).any(axis=1)
    silent = wrong & ~told.anything
    since = errors.time_s >= fault.at_s - INSTANT_S
    return FaultScore(
        float(lasting_s[silent].sum()),
        float(lasting_s[wrong].sum()),
        right_again(errors, fault),
        accurate_again(errors, clean, fault),
        float(errors.stds[since].max(initial=0.0)),
        float(errors.attitude_deg[since].max(initial=0.0)),
        float(errors.tip_mm[since].max(initial=0.0)),
        float(lasting_s[told.anything].sum()),
        float(lasting_s[errors.told.any_flag].sum()),
        raised(clean.told.any_flag),
        float(clean.lasting_s[clean.told.any_flag].sum()),
        told.words(lasting_s),
        is_finite=bool(np.isfinite(errors.stds).all()),
    )


def broken(why: str) -> FaultScore:
    """Return the score of a run that broke off: never right, infinitely wrong."""
    inf, nan = math.inf, math.nan
    return FaultScore(
        inf, inf, inf, inf, inf, inf, inf, nan, nan, 0, nan, broke=why, is_finite=False
    )


def limits(clean: RunErrors) -> Array:
    """Return in how many deviations (k,) a judged quantity is wrong."""
    return np.maximum(WRONG_STDS, OF_CLEAN * clean.stds.max(axis=0))


def right_again(errors: RunErrors, fault: Fault) -> float:
    """Return how long until at most `MOST_OFF` of the instants exceed `RIGHT_STDS`, s."""
    worst = errors.stds.max(axis=1)

    def holds(rows: slice) -> bool:
        off = worst[rows][worst[rows] > RIGHT_STDS]
        if len(off) <= MOST_OFF * len(worst[rows]):
            return True
        return fault.stays and len(off) == 1 and bool(off[0] <= WRONG_STDS)

    return _first(errors, fault, holds)


def accurate_again(errors: RunErrors, clean: RunErrors, fault: Fault) -> float:
    """Return how long until errors are again as small as without the fault, s.

    RMS at most 1.5 × that of the fault-free run + 0.3° of the judged angles, + 0.5 mm of the tip.
    """
    settled = clean.time_s >= clean.time_s[0] + SETTLED_S
    most = [
        (errors.attitude_deg, OF_CLEAN * _rms(clean.attitude_deg[settled]) + SLACK_DEG),
        (errors.tip_mm, OF_CLEAN * _rms(clean.tip_mm[settled]) + SLACK_MM),
    ]
    return _first(
        errors, fault, lambda rows: all(_rms(each[rows]) <= limit for each, limit in most)
    )


def _first(errors: RunErrors, fault: Fault, holds: Callable[[slice], bool]) -> float:
    """Return how long after a fault is over something begins to hold, s.

    It has to hold of an instant and all within `RIGHT_FOR_S` behind it, which the recording does
    not cut short; of all that follow where the fault stays.
    """
    time_s = errors.time_s
    within = np.searchsorted(time_s, time_s + RIGHT_FOR_S + INSTANT_S)
    ends = np.full(len(time_s), len(time_s)) if fault.stays else within
    whole = time_s + RIGHT_FOR_S <= time_s[-1] + errors.lasting_s[-1] + INSTANT_S
    for row in np.flatnonzero((time_s >= fault.over_s - INSTANT_S) & whole):
        if holds(slice(row, ends[row])):
            return max(float(time_s[row]) - fault.over_s, 0.0)
    return math.inf


def raised(flags: NDArray[np.bool_]) -> int:
    """Return how often a flag (n,) goes up."""
    return int((np.diff(flags.astype(int), prepend=0) > 0).sum())


def _rms(values: Array) -> float:
    with np.errstate(over="ignore"):
        return float(np.sqrt(np.mean(values**2)))
