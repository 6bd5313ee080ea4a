"""Constants of the backtracking line search, shared by both engines.

A step of length α along a Gauss-Newton direction is taken when the window's cost falls by
at least `SUFFICIENT` · α · ‖step‖² (Armijo, as ‖step‖² in whitened units is the slope's
size), give or take rounding; else α is halved.

References
----------
Nocedal, Wright (2006), Numerical Optimization, sections 3.1 and 10.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

SUFFICIENT = 1e-4
ROUNDING = 1e-13
SHORTEST_STEP = 1e-10
FLOOR = 1e-6

LINE_SEARCH: Mapping[str, float] = MappingProxyType(
    {
        "SUFFICIENT": SUFFICIENT,
        "ROUNDING": ROUNDING,
        "SHORTEST_STEP": SHORTEST_STEP,
        "FLOOR": FLOOR,
    }
)
"""As macros: `ROUNDING` relative to the cost; below `SHORTEST_STEP` the search ends; a step
shorter than `FLOOR` standard deviations that cannot be improved counts as converged."""
