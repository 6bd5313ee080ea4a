"""Where an accelerometer sits, seen from the point about which it is turned.

While the tip rests, a chip at r from it, in its own axes, reads f = Rᵀ (g + d²/dt² (R r)), with R
from its axes to those of a window's start, integrated from a gyroscope. A test function ψ with
∫ψ = 0 that vanishes with its derivative at the window's ends drops gravity and differentiates R
for us:

    ∫ ψ R f dt = (∫ ψ'' R dt) r.

That is linear in r. Its direction is the pen's axis where the chip sits on it: what gravity alone
cannot tell. Whether the tip rests tells how much of ∫ ψ R f dt the lever explains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array
from recordings.window_rows import longest_gaps_s, window_rows, window_starts

WINDOW_S = 1.6
"""Test functions have 0.6 to 3 Hz in it, as a hand has."""
LONGEST_GAP_S = 0.12
MOST_WINDOWS = 200
HARMONICS = 4
BIAS_STD_M_S2 = 0.3
"""Of the accelerometer's bias, which the test functions see as the chip turns."""
ROUNDS = 6
HUBER = 2.0


@dataclass(frozen=True, eq=False)
class Lever:
    """The place of a chip.

    Parameters
    ----------
    arm_m : (3,) from the point that rests, in the accelerometer's axes
    std_m : (3,)
    explained : part of the readings' changes, noise apart, that it explains: near 1 while the tip
        rests
    windows : number
    """

    arm_m: Array
    std_m: Array
    explained: float
    windows: int

    @property
    def length_m(self) -> float:
        """Distance from the point that rests."""
        return float(np.linalg.norm(self.arm_m))

    @property
    def axis(self) -> Array:
        """(3,) direction from the point that rests to the chip."""
        return np.asarray(self.arm_m / self.length_m)


def lever_of(
    force_time_s: Array,
    force: Array,
    rate_time_s: Array,
    rate: Array,
    *,
    noise_std: float = 0.0,
) -> Lever | None:
    """Return where a chip sits; None where no window is whole.

    Parameters
    ----------
    force_time_s, force : (n,), (n, 3) specific force, m/s²
    rate_time_s, rate : (m,), (m, 3) angular rate about the same axes without bias, rad/s
    noise_std : of one axis of a force at rest, which no lever has to explain
    """
    t = force_time_s
    if len(t) < 2 or len(rate) < 2:
        return None
    omega = np.column_stack([np.interp(t, rate_time_s, column) for column in rate.T])
    starts = window_starts(t, WINDOW_S, most=MOST_WINDOWS)
    starts = starts[longest_gaps_s(t, starts, WINDOW_S) <= LONGEST_GAP_S]
    y, C, D, chance = [], [], [], []
    for start, here in zip(starts, window_rows(t, starts, WINDOW_S), strict=True):
        at = t[here]
        if len(at) < 4 * HARMONICS:
            continue
        R = _attitudes(at, omega[here])
        psi, bent = _test_functions((at - start) / WINDOW_S)
        edges = np.concatenate([[start], (at[1:] + at[:-1]) / 2, [start + WINDOW_S]])
        dt = np.diff(edges)
        turned = np.einsum("nij,nj->ni", R, force[here])
        y.append((psi * dt) @ turned)
        C.append(np.einsum("kn,nij->kij", bent / WINDOW_S**2 * dt, R))
        chance.append(3 * noise_std**2 * np.sum((psi * dt) ** 2))
        D.append(np.einsum("kn,nij->kij", psi * dt, R))
    if not y:
        return None
    return _fitted(np.array(y), np.array(C), np.array(D), np.array(chance))


def _fitted(y: Array, C: Array, D: Array, chance: Array) -> Lever:
    """Fit arm and bias to y (w, k, 3) = C r + D b of w windows and k functions, robustly.

    Parameters
    ----------
    chance : (w,) what noise alone makes of the squares of y
    """
    windows = len(y)
    A = np.concatenate([C, D], axis=3).reshape(windows, -1, 6)
    flat = y.reshape(windows, -1)
    weight, theta, residual = np.ones(windows), np.zeros(6), flat
    for _ in range(ROUNDS):
        H = np.einsum("w,wca,wcb->ab", weight, A, A, optimize=True)
        prior = [0.0] * 3 + [(_std(residual, weight) / BIAS_STD_M_S2) ** 2] * 3
        H += np.diag(prior) + np.finfo(float).eps * np.trace(H) * np.eye(6)
        theta = np.linalg.solve(H, np.einsum("w,wca,wc->a", weight, A, flat, optimize=True))
        residual = flat - A @ theta
        size = np.sqrt(np.mean(residual**2, axis=1))
        weight = 1 / np.maximum(size / (HUBER * np.median(size) + np.finfo(float).tiny), 1.0)
    noise = float(weight @ chance)
    left = max(float(weight @ np.sum(residual**2, axis=1)) - noise, 0.0)
    whole = float(weight @ np.sum((flat - A[:, :, 3:] @ theta[3:]) ** 2, axis=1)) - noise
    covariance = 2 * _std(residual, weight) ** 2 * np.linalg.inv(H)
    return Lever(
        theta[:3],
        np.sqrt(np.diag(covariance)[:3]),
        1 - left / whole if whole > 0 else 0.0,
        windows,
    )


def _std(residual: Array, weight: Array) -> float:
    return float(
        np.sqrt(np.sum(weight[:, None] * residual**2) / (weight.sum() * residual.shape[1]))
    )


def _attitudes(t: Array, omega: Array) -> Array:
    """Return the (n, 3, 3) attitudes that rates (n, 3) turn the first one, the identity, to."""
    middle = (omega[1:] + omega[:-1]) / 2 * np.diff(t)[:, None]
    steps = Rotation.from_rotvec(middle).as_matrix()
    R = np.empty((len(t), 3, 3))
    R[0] = np.eye(3)
    for k, step in enumerate(steps):
        R[k + 1] = R[k] @ step
    return R


def _test_functions(s: Array) -> tuple[Array, Array]:
    """Return ψ and its second derivative (k, n) at s (n,) in 0 to 1: waves in sin⁴(πs)."""
    waves = _in_cosines()
    theta = 2 * np.pi * np.arange(HARMONICS + 3)[:, None] * s
    cosines, sines = np.cos(theta), np.sin(theta)
    factor = -((2 * np.pi * np.arange(HARMONICS + 3)) ** 2)
    even, odd = waves
    psi = np.concatenate([even @ cosines, odd @ sines])
    bent = np.concatenate([(even * factor) @ cosines, (odd * factor) @ sines])
    return psi, bent


def _in_cosines() -> tuple[Array, Array]:
    """Return the coefficients of the even functions by cosines and of the odd ones by sines."""
    n = HARMONICS + 3
    hann = {0: 3 / 8, 1: -1 / 2, 2: 1 / 8}  # of sin⁴(πs) by cos(2πjs)
    even, odd = np.zeros((HARMONICS + 1, n)), np.zeros((HARMONICS, n))
    for k in range(HARMONICS + 1):
        for j, c in hann.items():
            for m in (k + j, k - j):
                even[k, abs(m)] += c / 2
                if k:
                    odd[k - 1, abs(m)] += np.sign(m) * c / 2
    _, _, basis = np.linalg.svd(even[:, :1].T)
    return basis[1:] @ even, odd
