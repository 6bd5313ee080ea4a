"""Try acados' settings: ``python -m tests.suites.speed.acados_grid pen15_20_bounded``."""

from __future__ import annotations

import sys
from functools import partial

import numpy as np

from suites.speed.acados_contender import Acados
from suites.speed.acados_settings import TRIED
from suites.speed.contender import ONE_PASS, Entry
from suites.speed.own_contenders import WindowStep
from suites.speed.problems import find_problem
from suites.speed.races import WARM_UP
from suites.speed.runner import Racer, built, race
from suites.speed.windows import SpeedWindow, solved_windows

WINDOWS = 20


def try_settings(key: str) -> None:
    """Print per setting the CPU time, and how far its step is from this project's at most."""
    solved = solved_windows(find_problem(key), WARM_UP + WINDOWS)
    windows, model = [each.window for each in solved], solved[0].window.model
    entries: list[Entry[SpeedWindow]] = [
        Entry("mhe-rti", ONE_PASS, partial(WindowStep, name="mhe-rti")),
        *(Entry(str(each), ONE_PASS, partial(Acados, settings=each)) for each in TRIED),
    ]
    racers = built(entries, model, windows[0], lambda name, why: print(f"{name}: {why}"))
    share = race(racers, windows, WARM_UP)
    print(f"{key}, {share:.0%} of a core; CPU min, median (µs), away (standard deviations)")
    for racer in racers:
        least = 1e6 * min(turn.cpu_s.min() for turn in racer.turns)
        median = 1e6 * np.median([np.median(turn.cpu_s) for turn in racer.turns])
        away = max(
            np.abs(model.difference(own, first).full().ravel() / each.optimum.newest.std).max()
            for own, first, each in zip(
                _newest(racer), _newest(racers[0]), solved[WARM_UP:], strict=True
            )
        )
        print(f"{least:9.1f} {median:9.1f} {away:9.1e}  {racer.entry.name}")


def _newest(racer: Racer[SpeedWindow]) -> list[np.ndarray]:
    return [outcome.newest for outcome in racer.outcomes]


if __name__ == "__main__":
    for name in sys.argv[1:]:
        try_settings(name)
