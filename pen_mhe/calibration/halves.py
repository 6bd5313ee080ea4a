"""What one half of a recording found, judged by how it predicts the other.

Near the numbers v that were found for the whole, the score of a half is

    q(θ) = s · (θ - v) - ½ (θ - v)ᵀ H (θ - v),

s and H of its frames (`pen_mhe.calibration.camera_fit`). A quantity is worth taking if the other
half's numbers score better with it than without, all others being found anew each time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from pen_mhe.calibration.camera_fit import FrameEvidence
from pen_mhe.calibration.mounting import MountingQuantity, Number


def in_halves(evidence: FrameEvidence) -> tuple[FrameEvidence, FrameEvidence]:
    """Return what the frames of the first half tell, and those of the second."""
    is_late = evidence.time_s > 0.5 * (evidence.time_s.min() + evidence.time_s.max())
    return evidence.rows(~is_late), evidence.rows(is_late)


def worth(evidence: FrameEvidence, free: NDArray[np.bool_]) -> float:
    """Return the score of both halves with what the other found, all but some numbers at zero.

    Relative to that of the numbers of the evidence; every pass counts.
    """
    first, second = in_halves(evidence)
    return _score(first, _found(second, free)) + _score(second, _found(first, free))


def _found(half: FrameEvidence, free: NDArray[np.bool_]) -> Array:
    """Return what a half finds (k,) with some numbers free and the others zero."""
    s, H = half.score.sum(axis=0), half.information.sum(axis=0)
    found = np.zeros(len(free))
    found[free] = np.linalg.solve(H[np.ix_(free, free)], (s + H @ half.values)[free])
    return found


def _score(half: FrameEvidence, values: Array) -> float:
    s, H, away = half.score.sum(axis=0), half.information.sum(axis=0), values - half.values
    return float(s @ away - 0.5 * away @ H @ away)


def worth_taking(
    evidence: FrameEvidence, numbers: Sequence[Number], told: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which numbers (k,) are, a quantity with all its axes or not at all."""
    kept = told.copy()
    best = worth(evidence, kept)
    while kept.any():
        tried: dict[MountingQuantity, NDArray[np.bool_]] = {
            q: kept & np.array([n.quantity is not q for n in numbers])
            for q in dict.fromkeys(n.quantity for n, own in zip(numbers, kept, strict=True) if own)
        }
        scores = {q: worth(evidence, without) for q, without in tried.items()}
        least = max(scores, key=lambda q: scores[q])
        if scores[least] <= best:
            break
        kept, best = tried[least], scores[least]
    return kept
