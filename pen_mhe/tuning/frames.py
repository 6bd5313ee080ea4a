"""Noise levels by frames that are withheld: -log N(v; 0, S) of what predicts them, nats a frame.

With every m-th frame only, for each rate and several phases: each is judged as it is predicted by
estimates that got none since the one m before it. What is between them, the other sensors say.

It does not choose the camera's own noise: errors that stay from frame to frame look like motion
that is well predicted, so it trusts frames more than they deserve.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel
from pen_mhe.tuning.likelihood import log_likelihood
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import NATS, Filter, Judge, Score

RATES_HZ = (10.0, 5.0, 3.0)
"""At a higher one frames predict each other, at a lower one nothing predicts them."""
PHASES = 3
"""Of each rate, at most: more cost more, and share their errors."""
FEWEST_FRAMES = 30


def frame_choices(frame_s: Array) -> Mapping[int, float]:
    """Return every how many frames (at times (m,)) one is taken → the rate, Hz, that this makes."""
    rate_hz = (len(frame_s) - 1) / float(frame_s[-1] - frame_s[0])
    every = (max(1, round(rate_hz / rate)) for rate in RATES_HZ)
    return MappingProxyType({m: rate_hz / m for m in every})


def camera_rows(model: StateSpaceModel) -> NDArray[np.bool_]:
    """Return which rows (n_r,) of the residual are a camera's."""
    return np.concatenate([np.full(s.n_r, s.sees_pose) for s in model.sensors])


def by_frames(part: ScoredPart) -> Judge:
    """Return the judge of a part; `InputError` where no frame can be predicted."""
    if len(part.cameras) != 1:
        raise InputError("objective frames: expected one camera among the sensors")
    if not any(s.is_measured and not s.sees_pose for s in part.model.sensors):
        raise InputError("objective frames: no other sensor is left between frames")
    time_s, _ = part.stacked
    at, _ = part.frames(part.cameras[0])
    count = int((time_s[at] > part.counts_from_s).sum())
    if count < FEWEST_FRAMES:
        raise InputError(
            f"recording {part.recording.name}: {count} frames of {part.cameras[0].name} to "
            f"predict, expected at least {FEWEST_FRAMES}"
        )
    rows = camera_rows(part.model)
    rates = frame_choices(time_s[at])
    passes = list(_passes(part, at, rates))
    frames_per_pass = count * sum(1 / every for every, _ in passes) / len(passes)

    def judged(run: Filter, pen: PenConfig) -> Score:
        found: dict[int, list[float]] = {every: [] for every in rates}
        for every, y in passes:
            history = run(pen, time_s, y, covariances=True).between(part.counts_from_s)
            frames = (~np.isnan(history.innovation[:, rows]).all(axis=1)).sum()
            found[every].append(log_likelihood(history, rows) / max(frames, 1))
        by_rate = {every: float(np.mean(values)) for every, values in found.items()}
        value = -float(np.mean(list(by_rate.values())))
        return Score(
            value if math.isfinite(value) else math.inf,
            {f"nats a frame, {rates[every]:.3g} Hz": each for every, each in by_rate.items()},
            NATS / frames_per_pass,
        )

    return judged


def _passes(
    part: ScoredPart, at: NDArray[np.int_], rates: Mapping[int, float]
) -> Iterator[tuple[int, Array]]:
    """Yield every how many frames, and the readings (n, n_y) with these frames only."""
    for every in rates:
        phases = min(every, PHASES)
        for phase in (every * i // phases for i in range(phases)):
            hidden = np.zeros(len(part.stacked[0]), dtype=bool)
            hidden[at[np.arange(len(at)) % every != phase]] = True
            yield every, part.without([part.cameras[0].name], hidden)
