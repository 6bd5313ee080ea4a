"""Limits that the compiled and the interpreted loop share; what they mean stands in those loops."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

EXCESS = 1e-9


DEPENDENT = 1e-13


MOST_CHANGES = 10


MET = 1e-11


ENOUGH = 1e-2


MOST_REFINEMENTS = 3


MOST_ACTIVE = 200


ACTIVE_SET: Mapping[str, float] = MappingProxyType(
    {
        "EXCESS": EXCESS,
        "DEPENDENT": DEPENDENT,
        "MOST_CHANGES": MOST_CHANGES,
        "MET": MET,
        "ENOUGH": ENOUGH,
        "MOST_REFINEMENTS": MOST_REFINEMENTS,
    }
)
"""The constants as macros for C."""


def most_active(n_stages: int, n_c: int) -> int:
    """Return how many rows a window's set may hold."""
    return min(n_stages * n_c, MOST_ACTIVE)


FIRST: Mapping[str, float] = MappingProxyType({"FIRST_PASSES": 20, "FIRST_SETTLED": 1e-3})
"""Macros of window.c: how many passes a sensor's first readings get at most that came late, and the
step, in standard deviations, that ends them. A start within its prior takes 4."""


SUFFICIENT = 1e-4


ROUNDING = 1e-13


SHORTEST_STEP = 1e-10


GATE = 0.3


SINGULAR = 1e-12


RESOLUTION = 1e-12


SHORTEST_SETTLING = 1e-2


FLOOR = 1e-6


WOUND = 1e-6


MOST_TURNS = 3


DESCENT: Mapping[str, float] = MappingProxyType(
    {
        "SUFFICIENT": SUFFICIENT,
        "ROUNDING": ROUNDING,
        "SHORTEST_STEP": SHORTEST_STEP,
        "GATE": GATE,
        "SINGULAR": SINGULAR,
        "RESOLUTION": RESOLUTION,
        "SHORTEST_SETTLING": SHORTEST_SETTLING,
        "FLOOR": FLOOR,
        "WOUND": WOUND,
        "MOST_TURNS": MOST_TURNS,
    }
)
"""The constants as macros for C."""
