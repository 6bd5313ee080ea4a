"""Noise levels by how flat the tip stays while it presses; contact is not given to the filter.

The geometric mean of the spreads with every first, third and tenth frame of the camera: with all
frames alone, the biases of a short recording are fitted to its noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.tuning.parts import ScoredPart
from pen_mhe.tuning.score import Filter, Judge, Score

FEWEST_TOUCHES = 30
EVERY, SLOWEST_HZ = (1, 3, 10), 2.5
"""Which frames are used, down to a rate."""
OF_SPREAD = 0.01
"""A loss that is as good as none."""


def plane_spread_m(tip: Array) -> float:
    """Return the root mean square distance in height of points (m, 3) from a plane fitted to them.

    The plane may slope: a desk that is not level is no error.
    """
    design = np.column_stack([np.ones(len(tip)), tip[:, :2] - tip[:, :2].mean(axis=0)])
    plane, *_ = np.linalg.lstsq(design, tip[:, 2], rcond=None)
    return float(np.sqrt(np.mean((tip[:, 2] - design @ plane) ** 2)))


def by_flatness(part: ScoredPart) -> Judge:
    """Return the judge of a part; `InputError` where no touch or no camera is in it."""
    touches = part.touches_s
    if len(touches) < FEWEST_TOUCHES:
        raise InputError(
            f"recording {part.recording.name}: the tip touches at {len(touches)} counted "
            f"instants, expected at least {FEWEST_TOUCHES} (a contact sensor in pen file and "
            "recording) to tell how flat it stays"
        )
    if not part.cameras:
        raise InputError("objective flatness without a camera: nothing then sees the tip's height")
    time_s, _ = part.stacked
    rows = np.searchsorted(time_s, touches, side="right") - 1
    runs = {f"height spread at {rate_hz:.3g} Hz (mm)": y for rate_hz, y in _thinned(part)}

    def judged(run: Filter, pen: PenConfig) -> Score:
        figures = {}
        for name, y in runs.items():
            history = run(pen, time_s, y)
            tip = np.column_stack([history.column(f"tip_{axis}_m") for axis in "xyz"])[rows]
            figures[name] = 1e3 * plane_spread_m(tip) if np.isfinite(tip).all() else math.inf
        spread = math.exp(np.mean(np.log(list(figures.values()))))
        return Score(spread, figures, OF_SPREAD * spread)

    return judged


def _thinned(part: ScoredPart) -> Iterator[tuple[float, Array]]:
    """Yield camera rates, and the readings (n, n_y) with so many frames: all first."""
    time_s, _ = part.stacked
    for every in EVERY:
        hidden = np.zeros(len(time_s), dtype=bool)
        slowest = math.inf
        for camera in part.cameras:
            at, _ = part.frames(camera)
            slowest = min(slowest, (len(at) - 1) / max(time_s[-1] - time_s[0], 1e-9) / every)
            hidden[at[np.arange(len(at)) % every != 0]] = True
        if every == 1 or slowest >= SLOWEST_HZ:
            yield slowest, part.without([camera.name for camera in part.cameras], hidden)
