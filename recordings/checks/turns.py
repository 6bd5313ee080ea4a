"""How gravity turned in an accelerometer's axes, beside what a gyroscope says, window by window.

While a pen moves gently, the direction u = f/|f| of its specific force f is fixed in the world, and
in body axes ``du/dt = -ω × u``. With a Hann window φ over 1 s, integrated by parts so that
nothing is differentiated,

    Δ = -∫ φ' u dt = -∫ φ ω × u dt,    (∫ φ ω × u dt)_c = ε_cab Z_ab,   Z = ∫ φ ω uᵀ dt.

With a gyroscope read in other axes, ω = P ω_read + b, both sides stay linear in P and b. The same
equation as of `recordings.turn_factor`, which finds its scale only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from recordings.window_rows import longest_gaps_s, window_rows, window_starts

WINDOW_S = 1.0
"""Shorter takes the hand's acceleration for turning, longer finds fewer windows."""
LONGEST_GAP_S = 0.12
"""A window with a longer gap between samples is left out."""
GENTLE = 0.15
"""A window counts if the RMS of |f|/g - 1 in it is at most this."""
MOST_WINDOWS = 400
"""Of a longer recording as many are taken, evenly."""
EPSILON = np.zeros((3, 3, 3))
"""ε_abc: 1 for abc in cyclic order, -1 against it."""
for _a, _b, _c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    EPSILON[_a, _b, _c], EPSILON[_b, _a, _c] = 1.0, -1.0


@dataclass(frozen=True, eq=False)
class GravityTurns:
    """Windows of gentle motion, w of them.

    Parameters
    ----------
    start_s : (w,)
    turned : (w, 3) Δ
    crossed : (w, 3, 3) Z
    leant : (w, 3) ∫ φ u dt
    """

    start_s: Array
    turned: Array
    crossed: Array
    leant: Array

    def __len__(self) -> int:
        return len(self.start_s)

    def some(self, chosen: NDArray[np.bool_]) -> GravityTurns:
        """Return some of the windows."""
        return GravityTurns(
            self.start_s[chosen], self.turned[chosen], self.crossed[chosen], self.leant[chosen]
        )

    @property
    def by_axes(self) -> Array:
        """(w, 3, 9) derivative of the prediction of Δ by the entries of P, row by row."""
        return -np.einsum("cad,wbd->wcab", EPSILON, self.crossed).reshape(len(self), 3, 9)

    @property
    def by_bias(self) -> Array:
        """(w, 3, 3) derivative of the prediction of Δ by b."""
        return -np.einsum("cad,wd->wca", EPSILON, self.leant)


def gravity_turns(
    force_time_s: Array, force: Array, rate_time_s: Array, rate: Array, *, lag_s: float = 0.0
) -> GravityTurns:
    """Return the windows of gentle motion.

    Parameters
    ----------
    force_time_s, force : (n,), (n, 3) specific force, any unit
    rate_time_s, rate : (m,), (m, 3) angular rate, rad/s
    lag_s : by which the gyroscope's stamps are taken to be late
    """
    norm = np.linalg.norm(force, axis=1)
    keep = norm > 0
    t, norm = force_time_s[keep], norm[keep]
    if len(t) < 2 or len(rate) < 2:
        return _gathered([])
    u = force[keep] / norm[:, None]
    rate_time_s = rate_time_s - lag_s
    omega = np.column_stack([np.interp(t, rate_time_s, column) for column in rate.T])
    rough = np.square(norm / np.median(norm) - 1)
    starts = window_starts(t, WINDOW_S, most=MOST_WINDOWS)
    gaps_s = [longest_gaps_s(times, starts, WINDOW_S) for times in (t, rate_time_s)]
    starts = starts[np.maximum(*gaps_s) <= LONGEST_GAP_S]
    found = []
    for start, here in zip(starts, window_rows(t, starts, WINDOW_S), strict=True):
        if here.stop - here.start < 2 or rough[here].mean() > GENTLE**2:
            continue
        phase, dt = 2 * np.pi * (t[here] - start) / WINDOW_S, _weights(t[here], start)
        phi = dt * (1 - np.cos(phase)) / 2
        phi_dot = dt * np.pi / WINDOW_S * np.sin(phase)
        found.append(
            (
                start,
                -phi_dot @ u[here],
                (phi[:, None] * omega[here]).T @ u[here],
                phi @ u[here],
            )
        )
    return _gathered(found)


def _gathered(found: list[tuple[float, Array, Array, Array]]) -> GravityTurns:
    starts, turned, crossed, leant = zip(*found, strict=True) if found else ((), (), (), ())
    return GravityTurns(
        np.array(starts, dtype=float),
        np.reshape(turned, (-1, 3)),
        np.reshape(crossed, (-1, 3, 3)),
        np.reshape(leant, (-1, 3)),
    )


def _weights(time_s: Array, start_s: float) -> Array:
    """Return how much of the window each sample stands for (n,), s."""
    edges = np.concatenate([[start_s], (time_s[1:] + time_s[:-1]) / 2, [start_s + WINDOW_S]])
    return np.diff(edges)
