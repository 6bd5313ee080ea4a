"""A recording with fewer frames: what is between them, the inertial sensors must say.

Each rate takes every m-th frame, and every phase of that, so every frame is predicted once at
each rate, from what was before it and without the m - 1 frames in between.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel
from pen_mhe.tuning.frames import frame_choices
from pen_mhe.tuning.parts import SETTLING_S

SHORTEST_S, FEWEST_FRAMES = 16.0, 60
"""Of what counts: deviations are told by how parts of a recording differ."""


@dataclass(frozen=True, eq=False)
class FramePass:
    """Stacked readings with one choice of frames.

    Parameters
    ----------
    every : frames from one to the next, as recorded
    time_s, y : (n,), (n, n_y); an instant with a frame has nothing else
    frames : (m,) the instants with a frame that counts
    """

    every: int
    time_s: Array
    y: Array
    frames: NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Frames:
    """A recording's frames, and all other readings.

    Parameters
    ----------
    frame_s, frame_y : (m,), (m, n_y) as stamped
    other_s, other_y : (n,), (n, n_y)
    """

    frame_s: Array
    frame_y: Array
    other_s: Array
    other_y: Array

    @classmethod
    def of(cls, recording: Recording, model: StateSpaceModel) -> Frames:
        """Return the frames of a model's one camera.

        Raises
        ------
        InputError
            If they are too few to judge by.
        """
        used = recording.select([sensor.name for sensor in model.measured_sensors])
        time_s, y = used.stacked(model)
        seen = np.concatenate([np.full(s.n_y, s.sees_pose) for s in model.sensors])
        frames, others = np.where(seen, y, np.nan), np.where(seen, np.nan, y)
        has_frame, has_other = (~np.isnan(part).all(axis=1) for part in (frames, others))
        found = cls(time_s[has_frame], frames[has_frame], time_s[has_other], others[has_other])
        count = found.count
        lasts_s = float(found.frame_s[-1] - found.starts_s) if count else 0.0
        if count < FEWEST_FRAMES or lasts_s < SHORTEST_S:
            raise InputError(
                f"recording {recording.name} has {count} frames in {lasts_s:.3g} s after its first "
                f"{SETTLING_S:g} s, expected at least {FEWEST_FRAMES} in {SHORTEST_S:g} s to "
                "calibrate by"
            )
        return found

    @property
    def starts_s(self) -> float:
        """From when on frames count: the filter has forgotten its prior."""
        return float(min(self.frame_s[0], self.other_s[0])) + SETTLING_S

    @property
    def count(self) -> int:
        """How many frames count."""
        if not len(self.frame_s) or not len(self.other_s):
            return 0
        return int((self.frame_s > self.starts_s).sum())

    @property
    def choices(self) -> Mapping[int, float]:
        """Every how many frames one is taken → the rate, Hz, that this makes."""
        return frame_choices(self.frame_s)

    def passes(self, offset_s: float) -> Iterator[FramePass]:
        """Yield every rate and phase, the frames captured some time after their stamps."""
        captured = self.frame_s + offset_s
        for every in self.choices:
            for phase in range(every):
                some = slice(phase, None, every)
                time_s = np.concatenate([captured[some], self.other_s])
                is_other = np.arange(len(time_s)) >= len(captured[some])
                order = np.lexsort([is_other, time_s])  # a frame before what has the same stamp
                y = np.concatenate([self.frame_y[some], self.other_y])[order]
                at = np.flatnonzero(~is_other[order])[self.frame_s[some] > self.starts_s]
                yield FramePass(every, time_s[order], y, at)
