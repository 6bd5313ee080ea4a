"""The smallest value of a function of positive numbers, and how flat it is there.

Numbers are searched in their logarithms, by L-BFGS-B with finite differences. Values are
measured in losses: one is how much worse is as good as the optimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from models.arrays import Array

STEP = 1e-3
"""Of finite differences, in logarithms."""
WIDEST = 1e3
"""Factor by which a number may move from where it starts."""
BROKEN = 1e6
"""Losses of a choice with which the filter breaks down."""
TOLERANCE = 1e-4
"""Change of the value, relative, at which a round of the search ends."""
ROUNDS = 4
SETTLED = 0.02
"""Losses that a round must win for another one to follow."""
SCANNED = (1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0, 5.0, 10.0)
"""Factors at which a scan looks; a number that may change by the last one is not determined."""


@dataclass
class Search:
    """A search and the best that it has found.

    Parameters
    ----------
    value : of numbers (k,), smaller is better, inf where there is none; and the loss that is as
        good as an optimum there
    start : (k,) positive
    on_progress : called after each evaluation with their number and the best value
    """

    value: Callable[[Array], tuple[float, float]]
    start: Array
    on_progress: Callable[[int, float], None] | None = None
    best: Array = field(init=False)
    best_value: float = field(init=False, default=math.inf)
    loss: float = field(init=False, default=1.0)
    evaluations: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.best = self.start.copy()

    def _value(self, numbers: Array) -> float:
        value, loss = self.value(numbers)
        self.evaluations += 1
        if value < self.best_value:
            self.best, self.best_value, self.loss = numbers.copy(), value, loss
        if self.on_progress:
            self.on_progress(self.evaluations, self.best_value)
        return value

    def run(self) -> None:
        """Search until another round wins next to nothing."""
        from scipy.optimize import minimize  # slow to import

        first = self._value(self.start)
        origin = np.log(self.start)
        bounds = [(x - math.log(WIDEST), x + math.log(WIDEST)) for x in origin]
        for _ in range(ROUNDS):
            before = self.best_value
            unit = self.loss
            offset = before if math.isfinite(before) else 0.0

            def in_losses(x: Array, unit: float = unit, offset: float = offset) -> float:
                return float(min((self._value(np.exp(x)) - offset) / unit, BROKEN))

            minimize(
                in_losses,
                np.log(self.best),
                method="L-BFGS-B",
                bounds=bounds,
                options={"eps": STEP, "ftol": TOLERANCE, "gtol": 1e-3},
            )
            if before - self.best_value < SETTLED * unit and math.isfinite(first):
                break

    def ranges(self) -> list[tuple[float, float]]:
        """Return for each number the range in which, alone, it loses less than one loss.

        Its ends are 0 or inf where a factor of ten does not lose so much.
        """
        limit = self.best_value + self.loss
        at, best = self.best.copy(), self.best_value
        found = []
        for i in range(len(at)):
            sides = []
            for sign, open_end in ((-1.0, 0.0), (1.0, math.inf)):
                narrower = 1.0
                for wider in SCANNED:
                    tried = at.copy()
                    tried[i] *= wider**sign
                    reached = self._value(tried)
                    if reached > limit:
                        # A loss grows with the square of the logarithm, or nearly so.
                        share = math.sqrt((limit - best) / (reached - best))
                        sides.append(at[i] * max(wider**share, narrower) ** sign)
                        break
                    narrower = wider
                else:
                    sides.append(open_end)
            found.append((sides[0], sides[1]))
        return found
