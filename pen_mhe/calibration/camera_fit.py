"""Numbers that predict the frames best, and how sure they are.

Of the frame y_k at any of the rates and phases, given all before, the filter says N(v_k; 0, S_k).
With Z_k = -∂v_k/∂θ the numbers θ solve

    Σ Z_kᵀ S_k⁻¹ v_k = 0,        by  θ ← θ + H⁻¹ Σ Z_kᵀ S_k⁻¹ v_k,   H = Σ Z_kᵀ S_k⁻¹ Z_k.

Where the model is right the terms have mean zero given what was before, whatever S is: it is the
score of the predictive density, without what a number gains by telling how sure a prediction is.

How sure: passes share frames and readings, so H counts them several times. Deviations are
√diag(H⁻¹ J H⁻¹), J from sums of the terms over blocks of `BLOCK_S`, leaving each out in turn (the
jackknife), with what the rates by themselves differ by added in squares: a motion that the model
expects otherwise shows there, as a delay.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.errors import InputError
from pen_mhe.calibration.frames import Frames
from pen_mhe.calibration.mounted_filter import MountedFilter
from pen_mhe.calibration.mounting import OFFSET

BLOCK_S = 2.0
"""Of the score: what is further apart counts as independent."""
TOLD = 0.1
"""Of what is plausible: a number that frames do not tell to less stays as it is. Of a pen that is
still, noise seems to tell of a time offset and of turns to a sixth to a half of it."""
SETTLED = 0.05
"""Of a deviation by H, the last step of each number."""
ROUNDS = 10

Progress = Callable[[int, float], None]


@dataclass(frozen=True, eq=False)
class FrameEvidence:
    """What all passes tell at some numbers (k,): a row per frame of a pass.

    Parameters
    ----------
    values : (k,)
    every : (m,) of the pass
    time_s, log_density, score, information : see `pen_mhe.calibration.mounted_filter.Told`
    """

    values: Array
    every: NDArray[np.int_]
    time_s: Array
    log_density: Array
    score: Array
    information: Array

    def rows(self, kept: NDArray[np.bool_]) -> FrameEvidence:
        """Return some of its rows."""
        parts = {
            f.name: getattr(self, f.name)[kept]
            for f in dataclasses.fields(self)
            if f.name != "values"
        }
        return FrameEvidence(self.values, **parts)

    @property
    def counted_once(self) -> float:
        """By what sums are divided so that each frame counts once a rate."""
        _, phases = np.unique(self.every, return_counts=True), np.unique(self.every)
        return float(phases.sum() / len(phases))


@dataclass(frozen=True, eq=False)
class Fit:
    """Numbers that were found.

    Parameters
    ----------
    values, std : (k,), zero and NaN of those that are not told
    told : (k,) which are
    """

    values: Array
    std: Array
    told: NDArray[np.bool_]


def gathered(filtered: MountedFilter, frames: Frames, values: Array) -> FrameEvidence:
    """Return what all passes tell; `InputError` where the filter breaks down."""
    is_offset = np.array([n.quantity is OFFSET for n in filtered.numbers])
    own = np.where(is_offset, 0.0, values)  # the stamps have it
    parts = []
    for each in frames.passes(float(values[is_offset].sum())):
        told = filtered.told(own, each.time_s, each.y, each.frames)
        every = np.full(len(each.frames), each.every)
        parts.append((every, told.time_s, told.log_density, told.score, told.information))
    found = FrameEvidence(values, *map(np.concatenate, zip(*parts, strict=True)))
    if not (np.isfinite(found.score).all() and np.isfinite(found.log_density).all()):
        raise InputError(
            f"pen {filtered.pen.name}: its filter breaks down on this recording, expected noise "
            "levels and a mounting that are nearly right"
        )
    return found


def told_by(evidence: FrameEvidence, plausible_std: Array) -> NDArray[np.bool_]:
    """Return which numbers (k,) are told: the least told are left out one by one."""
    once = evidence.information.sum(axis=0) / evidence.counted_once
    told = np.ones(len(plausible_std), dtype=bool)
    while told.any():
        P = np.linalg.inv(once[np.ix_(told, told)] + np.diag(plausible_std[told] ** -2))
        left = np.sqrt(np.diag(P)) / plausible_std[told]
        if left.max() <= TOLD:
            break
        told[np.flatnonzero(told)[np.argmax(left)]] = False
    return told


def solved(evidence: FrameEvidence, told: NDArray[np.bool_]) -> Fit:
    """Return the numbers one step from those of some evidence, and how sure they are."""
    at = np.flatnonzero(told)
    score, H = evidence.score[:, at], evidence.information[:, at][:, :, at]
    whole = H.sum(axis=0)
    step = np.linalg.solve(whole, score.sum(axis=0))
    blocks, of_row = np.unique((evidence.time_s // BLOCK_S).astype(int), return_inverse=True)
    n = len(blocks)
    sums, parts = np.zeros((n, len(at))), np.zeros((n, len(at), len(at)))
    np.add.at(sums, of_row, score - H @ step)
    np.add.at(parts, of_row, H)
    without = np.linalg.solve(whole - parts, -sums[:, :, None])[:, :, 0]
    variance = (n - 1) / n * np.sum((without - without.mean(axis=0)) ** 2, axis=0)
    apart = []
    for every in np.unique(evidence.every):
        own = evidence.every == every
        apart.append(np.linalg.solve(H[own].sum(axis=0), (score - H @ step)[own].sum(axis=0)))
    values, std = np.where(told, evidence.values, 0.0), np.full(len(told), np.nan)
    values[at] += step
    std[at] = np.sqrt(variance + np.mean(np.square(apart), axis=0))
    return Fit(values, std, told)


def fitted(
    filtered: MountedFilter,
    frames: Frames,
    start: FrameEvidence,
    *,
    free: NDArray[np.bool_],
    on_progress: Progress | None = None,
) -> tuple[Fit, FrameEvidence]:
    """Return the numbers, and what passes tell with them.

    Parameters
    ----------
    start : what passes tell before, from where it begins
    free : (k,) which may change
    on_progress : called with the number of the round and the mean log density of a frame

    Raises
    ------
    InputError
        If the filter breaks down, frames tell nothing, or the numbers do not settle.
    """
    evidence = start
    told = free & told_by(evidence, filtered.plausible_std)
    for number in range(1, ROUNDS + 1):
        if on_progress:
            on_progress(number, float(evidence.log_density.mean()))
        if not told.any():
            raise InputError(
                "frames tell none of "
                f"{', '.join(n.name for n in filtered.numbers)}: expected a moving pen"
            )
        fit = solved(evidence, told)
        if _settled(evidence, fit):
            return fit, evidence
        evidence = gathered(filtered, frames, fit.values)
        told &= told_by(evidence, filtered.plausible_std)
    raise InputError(
        f"the numbers do not settle within {ROUNDS} rounds, expected a pen file that is nearly "
        "right and a recording with more motion"
    )


def _settled(evidence: FrameEvidence, fit: Fit) -> bool:
    """Whether the last step was small against what H says of each number."""
    once = evidence.information.sum(axis=0)[np.ix_(fit.told, fit.told)] / evidence.counted_once
    moved = np.abs(fit.values - evidence.values)[fit.told]
    return bool((moved < SETTLED * np.sqrt(np.diag(np.linalg.inv(once)))).all())
