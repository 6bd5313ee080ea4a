"""How often the 95 % intervals of the verdicts hold the truth, by number of seeds.

Run as ``python -m benchmark.verdicts.coverage``.
"""

from __future__ import annotations

import numpy as np

from benchmark.verdicts.bootstrap import STATISTICS, Strata, interval

TRIALS = 2000
SEEDS = (3, 5, 10, 20, 30)


def coverage(seeds: int, cells: int = 1, trials: int = TRIALS) -> float:
    """Return the fraction of intervals of a mean that hold it: of Gaussian values, mean zero.

    Parameters
    ----------
    seeds : values per cell
    cells : cells that are resampled each by itself
    """
    rng, strata = np.random.default_rng(0), Strata(np.repeat(np.arange(cells), seeds))
    held = 0
    for trial in range(trials):
        values = rng.standard_normal(cells * seeds)
        found = interval(
            f"trial {trial}",
            strata,
            lambda index, v=values: STATISTICS["mean"](v[index]),  # type: ignore[misc]
            len(values),
        )
        held += found.low <= 0 <= found.high
    return held / trials


if __name__ == "__main__":
    for seeds in SEEDS:
        print(f"{seeds} seeds: {coverage(seeds):.1%} of one cell, {coverage(seeds, 10):.1%} of ten")
