"""A sensor's first readings, where they come late: passes until the step is short, as window.c."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from estimation.status import Status
from mhe.interpreted.convergence import Solved
from mhe.interpreted.sliding import WindowSlider
from mhe.late import sensors_there
from mhe.rules import FIRST
from mhe.window_memory import View
from models.state_space import StateSpaceModel


def is_first(model: StateSpaceModel, window: View, rows: NDArray[np.bool_]) -> bool:
    """Return whether rows (n_r,) bring a sensor's first readings; it is seen from then on."""
    before = window.seen.copy()
    window.seen[sensors_there(model, rows)] = 1
    return bool((window.seen != before).any())


def settled(
    window: View,
    one_pass: Callable[[View], Solved],
    slider: WindowSlider,
    can_go_on: Callable[[], bool],
) -> Solved:
    """Make passes, each linearised where the one before ended, while there is time."""
    solved, passes = one_pass(window), 1
    while (
        solved.status is Status.SOLVED
        and solved.kkt > FIRST["FIRST_SETTLED"]
        and passes < FIRST["FIRST_PASSES"]
    ):
        if not can_go_on():
            solved = replace(solved, status=Status.TIME_LIMIT)
            break
        slider.choose_points(window, 0)
        window.stayed[...] = 0
        solved, passes = one_pass(window), passes + 1
    return replace(solved, iterations=passes)
