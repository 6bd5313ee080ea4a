"""How much faster than a gyroscope says gravity turns in an accelerometer.

While a pen moves gently, the direction u = f/|f| of its specific force f is fixed in the world, so
in body axes it turns as

    du/dt = -k ω × u

with k = 1 if the gyroscope's rate ω is in its unit, k = π/180 if it is deg/s
read as rad/s, and k = 180/π the other way round. With a Hann window φ over 1 s,
integrated by parts so that nothing has to be differentiated,

    Δ = -∫ φ' u dt = k r,   r = -∫ φ (ω × u) dt

k is fitted over all windows in which the pen moved gently and turned. One second,
because the acceleration of the hand, which is taken for turning, fades with the
square of the window: on the D-POINT recording k is 2.3 over 0.2 s, 1.02 over 1 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from recordings.window_rows import longest_gaps_s, window_rows, window_starts

WINDOW_S = 1.0
LONGEST_GAP_S = 0.1
"""A window with a longer gap between samples is left out."""
GENTLE = 0.1
"""A window counts if the RMS of |f|/g - 1 in it is at most this …"""
LEAST_TURN_RAD = math.radians(1.5)
"""… and |Δ|, which no unit of a rate can change, at least this."""
LEAST_WINDOWS = 5
MOST_WINDOWS = 200
"""Of a longer recording as many are taken, evenly: they tell as much, and take less time."""
LEAST_CORRELATION = 0.75
HUBER = 1.5
"""Residuals beyond this many medians of |residual| lose weight."""
HUBER_STEPS = 20


def turn_factor(force_time_s: Array, force: Array, rate_time_s: Array, rate: Array) -> float | None:
    """Fit k of ``du/dt = -k ω × u``; None where the recording cannot tell.

    Parameters
    ----------
    force_time_s, force : (n,), (n, 3) specific force in body axes, any unit
    rate_time_s, rate : (m,), (m, 3) angular rate in body axes
    """
    turned, predicted = _turns(force_time_s, force, rate_time_s, rate)
    has_turned = np.linalg.norm(turned, axis=1) >= LEAST_TURN_RAD
    turned, predicted = turned[has_turned], predicted[has_turned]
    if len(turned) < LEAST_WINDOWS or not predicted.any():
        return None
    weight = np.ones((len(turned), 1))
    for _ in range(HUBER_STEPS):
        k = float((weight * turned * predicted).sum() / (weight * predicted**2).sum())
        residual = np.linalg.norm(turned - k * predicted, axis=1, keepdims=True)
        scale = HUBER * np.median(residual) + np.finfo(float).tiny
        weight = scale / np.maximum(residual, scale)
    length = np.sqrt((weight * turned**2).sum() * (weight * predicted**2).sum())
    correlation = (weight * turned * predicted).sum() / length
    return k if correlation >= LEAST_CORRELATION else None


@dataclass(frozen=True)
class RoughTurn:
    """What all windows tell of k, however rough the motion in them is.

    Parameters
    ----------
    most : RMS(Δ) / RMS(r), which k is about at most: what the hand pushes only adds to Δ
    correlation : of Δ with r
    """

    most: float
    correlation: float


def rough_turn(
    force_time_s: Array, force: Array, rate_time_s: Array, rate: Array
) -> RoughTurn | None:
    """Return what is left to say where `turn_factor` cannot tell; None without a window.

    Parameters
    ----------
    force_time_s, force, rate_time_s, rate : as of `turn_factor`; the median of the rate, which
        may be all bias, is taken off
    """
    if not len(rate):
        return None
    steady = rate - np.median(rate, axis=0)
    turned, predicted = _turns(force_time_s, force, rate_time_s, steady, roughest=np.inf)
    of_force, of_rate = float((turned**2).sum()), float((predicted**2).sum())
    if not (of_force > 0 and of_rate > 0):
        return None
    both = float((turned * predicted).sum())
    return RoughTurn(math.sqrt(of_force / of_rate), both / math.sqrt(of_force * of_rate))


def _turns(
    force_time_s: Array,
    force: Array,
    rate_time_s: Array,
    rate: Array,
    *,
    roughest: float = GENTLE,
) -> tuple[Array, Array]:
    """Return Δ and r (w, 3) of the module's equations, of every window of motion that is gentle.

    Parameters
    ----------
    roughest : RMS of |f|/g - 1 in a window that counts
    """
    norm = np.linalg.norm(force, axis=1)
    if len(rate) == 0 or not norm.any():
        return np.zeros((0, 3)), np.zeros((0, 3))
    t, norm, force = force_time_s[norm > 0], norm[norm > 0], force[norm > 0]
    rough = np.abs(norm / np.median(norm) - 1)
    starts = window_starts(t, WINDOW_S, most=MOST_WINDOWS)
    in_window = np.zeros(len(t), dtype=bool)
    for here in window_rows(t, starts, WINDOW_S):
        in_window[here] = True
    t, norm, force = t[in_window], norm[in_window], force[in_window]
    rough, u = np.square(rough[in_window]), force / norm[:, None]
    gaps_s = [longest_gaps_s(times, starts, WINDOW_S) for times in (t, rate_time_s)]
    starts = starts[np.maximum(*gaps_s) <= LONGEST_GAP_S]
    omega = np.column_stack([np.interp(t, rate_time_s, column) for column in rate.T])
    turn_rate = np.cross(omega, u)
    deltas, predictions = [], []
    for start, here in zip(starts, window_rows(t, starts, WINDOW_S), strict=True):
        # Of times so large that a second is nothing to them it has no two.
        if here.stop - here.start < 2 or math.sqrt(rough[here].mean()) > roughest:
            continue
        phase, dt = 2 * np.pi * (t[here] - start) / WINDOW_S, _steps(t[here])
        phi, phi_dot = (1 - np.cos(phase)) / 2, np.pi / WINDOW_S * np.sin(phase)
        deltas.append(-(phi_dot * dt) @ u[here])
        predictions.append(-(phi * dt) @ turn_rate[here])
    return np.reshape(deltas, (-1, 3)), np.reshape(predictions, (-1, 3))


def _steps(time_s: Array) -> Array:
    """Return half of the way from the sample before to the one behind: `numpy.gradient`."""
    found = np.empty(len(time_s))
    found[1:-1] = (time_s[2:] - time_s[:-2]) / 2
    found[0], found[-1] = time_s[1] - time_s[0], time_s[-1] - time_s[-2]
    return found
