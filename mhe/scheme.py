"""How a real-time estimator makes its passes over a window, as data."""

from __future__ import annotations

from dataclasses import dataclass

TOLERANCE, MAX_ITERATIONS = 1e-8, 300


@dataclass(frozen=True, kw_only=True)
class Scheme:
    """The passes of a step; see `mhe.realtime`.

    Parameters
    ----------
    converges : passes until a step is shorter than the tolerance; otherwise one, and its
        full step
    reuse_threshold : see `mhe.config.MheRtiConfig`; 0 makes every pass a full one
    tolerance, max_iterations : see `mhe.config.ConvergedConfig`; where there is one pass, of
        OSQP's only, which takes over a pass that fails (`mhe.sparse_qp.fallback`)
    """

    converges: bool
    reuse_threshold: float | None = 0.0
    tolerance: float = TOLERANCE
    max_iterations: int = MAX_ITERATIONS
