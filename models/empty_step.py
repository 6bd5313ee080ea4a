"""Whether a step of no time changes nothing: estimators take steps of Δt = 0."""

from __future__ import annotations

import casadi as ca
import numpy as np

from models.arrays import Array
from models.errors import InputError

TOLERANCE = 1e-12
"""Rounding that a step of Δt = 0 may leave, of a state and its standard deviation."""
POINTS = 20
"""Drawn from the prior, inside the bounds; more find a fault that hides in fewer places."""
SHORT_STEP_S = 1e-3
"""Where not even a step of this is finite, a model is not defined."""


def check_empty_step(
    model: str,
    states: tuple[str, ...],
    f: ca.Function,
    prior: tuple[Array, Array],
    bounds: tuple[Array, Array],
) -> None:
    """Raise `InputError` where a transition changes something at Δt = 0.

    Parameters
    ----------
    model : its name
    states : (n_x,) names
    f : (n_x,), (n_w,), (), inputs (n_u,) at both ends → (n_x,)
    prior : means and standard deviations (n_x,)
    bounds : lower and upper (n_x,)
    """
    rng = np.random.default_rng(0)
    mean, std = prior
    sizes = [f.numel_in(i) for i in range(3, f.n_in())]
    for _ in range(POINTS):
        x = _inside(mean + std * rng.standard_normal(len(mean)), mean, bounds, rng)
        w = rng.standard_normal(f.numel_in(1))
        # Positive: an input may be a mass, a temperature or a gain.
        inputs = [rng.uniform(0.1, 1.0, n) for n in sizes]
        moved = f(x, w, 0.0, *inputs).full().ravel() - x
        rest = np.abs(moved) <= TOLERANCE * (np.abs(x) + std)
        if rest.all() or not np.isfinite(f(x, w, SHORT_STEP_S, *inputs).full()).all():
            continue
        state = states[int(np.argmin(rest))]
        raise InputError(
            f"model {model}: a step of Δt = 0 changes {state}, expected that it changes nothing: "
            "scale noise by a power of Δt (white noise by √Δt)"
        )


def _inside(x: Array, mean: Array, bounds: tuple[Array, Array], rng: np.random.Generator) -> Array:
    """Return x (n_x,) with what lies outside drawn between its bound and the mean instead."""
    nearest, inner = np.clip(x, *bounds), np.clip(mean, *bounds)
    between = nearest + rng.uniform(size=len(x)) * (inner - nearest)
    return np.where(nearest == x, x, between)
