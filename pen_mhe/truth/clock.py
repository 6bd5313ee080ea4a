"""The offset of two clocks, by where two signals are most alike.

    r(τ) = max over turns R of Σ f·R g / √(Σ|f|² Σ|g|²)
    z(τ) = atanh r(τ) · √(seconds of overlap / MEMORY_S)

with f, g the two signals less their means, over their overlap at offset τ, gaps left out. The best
turn is the one of Kabsch: the sum is that of the singular values of Σ f gᵀ. The offset is where z
is largest: a short overlap may be alike by chance.

References
----------
Padfield (2012), Masked object registration in the Fourier domain, IEEE Trans. Image Processing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from models.arrays import Array
from pen_mhe.truth.motion import Signal

MEMORY_S = 0.3
"""After so long a hand's motion is another."""
LEAST_OVERLAP_S, LEAST_PART = 2.0, 0.2
"""The least overlap, and the least part of the shorter recording."""
LEAST_CORRELATION, LEAST_Z = 0.85, 4.0
"""Below them two signals are no more alike than those of two recordings."""
RIVAL = 0.9
"""A second offset whose z is beyond this part of the first's is as good …"""
APART_S = 0.5
"""… where it lies so far from it."""
STILL = 1e-9
LOOKED_AT = 0.5
"""Correlations that cannot reach this are not told exactly: most of a long recording's."""


@dataclass(frozen=True)
class FoundOffset:
    """What is added to a truth's times to have those of the estimate.

    Parameters
    ----------
    offset_s : None where it is not seen
    correlation : of what was compared, at its best
    why : it is not seen, in words; empty where it is
    """

    offset_s: float | None
    correlation: float
    name: str
    why: str = ""


def found_offset(signal: Signal) -> FoundOffset:
    """Return the offset that makes two signals most alike, or why none does."""
    a, b = signal.estimated, signal.true
    for one, whose in ((a, "estimate"), (b, "truth")):
        if not np.isfinite(one).any() or float(np.nanstd(one, axis=0).max()) <= STILL:
            why = f"{signal.name} of the {whose} does not change"
            return FoundOffset(None, 0.0, signal.name, why)
    lags, r, overlap = masked_correlation(a, b)
    seconds = overlap * signal.step_s
    known = min(int(np.isfinite(one).all(axis=1).sum()) for one in (a, b)) * signal.step_s
    enough = seconds >= max(LEAST_OVERLAP_S, LEAST_PART * known)
    if not enough.any():
        return FoundOffset(None, 0.0, signal.name, f"{known:.3g} s of it are known, which is short")
    z = np.arctanh(np.clip(r, -0.999999, 0.999999)) * np.sqrt(seconds / MEMORY_S)
    z[~enough] = -np.inf
    best = int(np.argmax(z))
    correlation = float(r[best])
    if correlation < LEAST_CORRELATION or z[best] < LEAST_Z:
        why = f"the correlation of {signal.name} is {correlation:.2f} at its best"
        return FoundOffset(None, correlation, signal.name, why)
    far = np.abs(lags - lags[best]) * signal.step_s > APART_S
    rival = int(np.argmax(np.where(far, z, -np.inf)))
    start_s = signal.estimated_s - signal.true_s
    if far.any() and z[rival] > RIVAL * z[best]:
        both = [start_s + lags[k] * signal.step_s for k in (best, rival)]
        why = f"{signal.name} is as much alike at {both[0]:.3f} and at {both[1]:.3f} s"
        return FoundOffset(None, correlation, signal.name, why)
    peak = lags[best] + _vertex(r, best)
    return FoundOffset(start_s + float(peak) * signal.step_s, correlation, signal.name)


def masked_correlation(a: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return lags, correlations and overlaps of two signals (n, k), (m, k); NaN is left out.

    At lag i sample j of b lies on sample i + j of a.
    """
    n, k = next_fast_len(len(a) + len(b) - 1), a.shape[1]
    known_a, known_b = (np.asarray(np.isfinite(one).all(axis=1)) for one in (a, b))
    # Whatever is the same in both is taken off first: less is lost to rounding.
    x, y = (
        np.where(known[:, None], one - one[known].mean(axis=0), 0.0)
        for one, known in ((a, known_a), (b, known_b))
    )

    def spectrum(values: Array) -> NDArray[np.complex128]:
        return np.asarray(rfft(values, n))

    def across(first: NDArray[np.complex128], second: NDArray[np.complex128]) -> Array:
        product = irfft(first * np.conj(second), n)
        return np.asarray(np.concatenate([product[n - len(b) + 1 :], product[: len(a)]]))

    m_a, m_b = spectrum(known_a.astype(float)), spectrum(known_b.astype(float))
    f, g = [spectrum(one) for one in x.T], [spectrum(one) for one in y.T]
    overlap = np.round(across(m_a, m_b))
    count = np.maximum(overlap, 1)
    sum_x, sum_y = [across(one, m_b) for one in f], [across(m_a, one) for one in g]
    both = np.empty((len(count), k, k))
    for i in range(k):
        for j in range(k):
            both[:, i, j] = across(f[i], g[j]) - sum_x[i] * sum_y[j] / count
    size_x, size_y = (x**2).sum(axis=1), (y**2).sum(axis=1)
    var_x = across(spectrum(size_x), m_b) - sum(one**2 for one in sum_x) / count
    var_y = across(m_a, spectrum(size_y)) - sum(one**2 for one in sum_y) / count
    floor = 1e-9 * np.sqrt(size_x.sum() * size_y.sum()) + np.finfo(float).tiny
    size = np.sqrt(np.maximum(var_x, 0) * np.maximum(var_y, 0))
    r = _turned(both, LOOKED_AT * size) / np.maximum(size, floor)
    r = np.where(size > floor, r, 0.0)
    return np.arange(-len(b) + 1, len(a), dtype=float), np.clip(r, -1, 1), overlap


def _turned(both: Array, least: Array) -> Array:
    """Return the largest sums (n,) of f·R g by their matrices Σ f gᵀ (n, k, k).

    One number has its sign, two may be mirrored (a tablet's y points up or down), three may not.

    Parameters
    ----------
    least : (n,) where the sum cannot reach it the matrix' norm, which is smaller, stands for it
    """
    if both.shape[1] == 1:
        return np.asarray(both[:, 0, 0])
    sums = np.sqrt((both**2).sum(axis=(1, 2)))
    near = np.sqrt(both.shape[1]) * sums >= least
    values = np.linalg.svd(both[near], compute_uv=False)
    if both.shape[1] == 3:
        values[:, -1] *= np.sign(np.linalg.det(both[near]))
    sums[near] = values.sum(axis=1)
    return np.asarray(sums)


def _vertex(r: Array, at: int) -> float:
    """Return how far from a sample the top of the parabola through it and its neighbours lies."""
    if not 0 < at < len(r) - 1:
        return 0.0
    low, middle, high = r[at - 1 : at + 2]
    bend = low - 2 * middle + high
    return 0.0 if bend >= 0 else float(np.clip(0.5 * (low - high) / bend, -0.5, 0.5))
