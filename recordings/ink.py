"""Mean ink distance: how far an estimated path lies from the ink on the paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from estimation.estimate import EstimateHistory
from models.arrays import Array
from models.border import reading
from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular
from models.shown_text import short

if TYPE_CHECKING:
    from recordings.ink_map import InkMap

INCH_MM = 25.4
OUTLIER_FACTOR = 2.0
RESAMPLING_MM = 0.5
TRIMMED_SAMPLES = 70
ALIGNMENT_ROUNDS, MOST_ROUNDS = 8, 100
"""Of nearest neighbour and mean: to compare starts; of the best one, until it settles."""

SETTLED_MM = 1e-6
STARTING_GRID_MM = 4.0
STARTING_POINTS = 300
OFF_PAPER = 3.0
COUNTED_AT_ONCE = 1_000_000
"""Pixels; counting takes eight times their memory."""


@dataclass(frozen=True, eq=False)
class Ink:
    """The ink that a recording left, (m, 2) mm, and when the pen pressed: (n,) s, 0 or 1."""

    points_mm: Array
    time_s: Array
    pressed: Array

    @cached_property
    def map(self) -> InkMap:
        """The map of the ink, made once for all paths that are laid over it."""
        from recordings.ink_map import InkMap  # slow to import, for scanned ink only

        return InkMap(self.points_mm)


@dataclass(frozen=True, eq=False)
class InkMatch:
    """A path laid over the ink, mm: both point sets, and how far the path's (n,) are from it."""

    distance_mm: Array
    path_mm: Array
    ink_mm: Array

    @property
    def mean_distance_mm(self) -> float:
        """Mean distance of the path from the ink; infinite for a path that is far off it."""
        return float(np.mean(self.distance_mm))


def otsu_threshold(grey: Array) -> int:
    """Return the grey level (0 to 255) that best separates two classes.

    Maximises the variance between the classes "at or below" and "above".

    References
    ----------
    Otsu (1979), IEEE Trans. Systems, Man, and Cybernetics 9(1).
    """
    flat = grey.astype(np.uint8, copy=False).ravel()
    parts = np.array_split(flat, 1 + len(flat) // COUNTED_AT_ONCE)
    counts = sum(np.bincount(part, minlength=256) for part in parts) + np.zeros(256)
    levels = np.arange(256)
    below = np.cumsum(counts)
    above = below[-1] - below
    sum_below = np.cumsum(counts * levels)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean_below = sum_below / below
        mean_above = (sum_below[-1] - sum_below) / above
        between = below * above * (mean_below - mean_above) ** 2
    return int(np.nanargmax(between))


def ink_points_mm(scan: str | Path) -> Array:
    """Return the ink pixels (n, 2) of a scan in mm, x to the right, y upwards.

    Pixels at or below the Otsu threshold, without those farther from the
    median point than twice the median distance.

    Raises
    ------
    InputError
        If the file is no image, has no resolution, is the same grey everywhere, or has more
        dark pixels than its limit.
    """
    from PIL import Image

    with (
        reading(scan, "an image"),
        open_regular(Path(scan), str(scan), "an image", "table_bytes") as file,
        _pillows_errors(scan),
        Image.open(file) as image,
    ):
        check_most("pixels", image.width * image.height, str(scan))
        dpi = float(image.info.get("dpi", (0,))[0])
        grey = np.asarray(image.convert("L"))
    if not (math.isfinite(dpi) and dpi > 0):
        raise InputError(f"{scan}: no resolution in the image's metadata, expected dpi")
    if not grey.size or grey.min() == grey.max():
        raise InputError(f"{scan}: the same grey everywhere, expected ink on paper")
    is_ink = grey <= otsu_threshold(grey)
    check_most("ink_pixels", int(np.count_nonzero(is_ink)), str(scan))
    rows, columns = np.divmod(np.flatnonzero(is_ink), grey.shape[1])
    height = len(grey)
    del grey, is_ink
    x, y = columns * INCH_MM / dpi, (height - 1 - rows) * INCH_MM / dpi
    del rows, columns
    distance = np.sqrt((x - np.median(x)) ** 2 + (y - np.median(y)) ** 2)
    is_near = distance <= OUTLIER_FACTOR * np.median(distance)
    return np.column_stack([x[is_near], y[is_near]])


@contextmanager
def _pillows_errors(scan: str | Path) -> Iterator[None]:
    """Raise `InputError` for what Pillow makes of a damaged image.

    How many pixels there may be is left to us: our limit says how it is raised.
    """
    from PIL import Image

    before, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:  # each of its formats has its own
        raise InputError(f"{scan}: {short(str(error))}, expected an image") from error
    finally:
        Image.MAX_IMAGE_PIXELS = before


def written_path_mm(tip_xy_m: Array, pressed: Array) -> Array:
    """Resample a path along its length and keep where the pen presses.

    Parameters
    ----------
    tip_xy_m : (n, 2) tip at the IMU samples
    pressed : (n,) 1 where the pen presses, 0 where not

    Raises
    ------
    InputError
        If the path is too short.
    """
    inner = slice(TRIMMED_SAMPLES, len(tip_xy_m) - TRIMMED_SAMPLES)
    xy, pressed = tip_xy_m[inner] * 1e3, np.asarray(pressed, dtype=float)[inner]
    if len(xy) < 2:
        raise InputError(
            f"path of {len(tip_xy_m)} samples is too short for the ink distance, "
            f"expected more than {2 * TRIMMED_SAMPLES + 1}"
        )
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
    at = np.arange(0, length[-1], RESAMPLING_MM)
    resampled = np.column_stack([np.interp(at, length, xy[:, i]) for i in range(2)])
    return resampled[np.interp(at, length, pressed) > 0.5]


def match_ink(path_mm: Array, ink: InkMap) -> InkMatch:
    """Shift a path onto the ink (never rotate or scale it) and measure the distance.

    The rounds of nearest neighbour and mean end in a local optimum, so they
    start from many shifts that lay the path's extent within the ink's: a part
    of a text fits in several places. The best one counts. Looking for it, a
    nearest neighbour is good to half a millimetre (`recordings.ink_map`).
    """
    coarse, tree, ink_mm = ink.nearest, ink.tree, ink.ink_mm
    thinned = path_mm[:: max(1, len(path_mm) // STARTING_POINTS)]
    starts = _starting_shifts(path_mm, ink_mm)
    shifts = [_settled_shift(thinned, coarse, start) for start in starts]
    best = min(shifts, key=lambda shift: _mean_distance(thinned + shift, coarse))
    shifted = path_mm + _settled_shift(
        path_mm, lambda at: ink_mm[tree.query(at)[1]], best, MOST_ROUNDS
    )
    return InkMatch(np.asarray(tree.query(shifted)[0]), shifted, ink_mm)


def ink_match(output: EstimateHistory, ink: Ink) -> InkMatch | None:
    """Lay the tip over the ink; None for a part too short to compare.

    A path `OFF_PAPER` times as large as the ink is infinitely far from it.
    """
    if len(output) <= 2 * TRIMMED_SAMPLES + 1:
        return None
    pressed = np.interp(output.time_s, ink.time_s, ink.pressed)
    tip_xy = np.column_stack([output.column("tip_x_m"), output.column("tip_y_m")])
    on_paper = 1e3 * tip_xy[TRIMMED_SAMPLES:-TRIMMED_SAMPLES]
    if np.ptp(on_paper, axis=0).max() > OFF_PAPER * np.ptp(ink.points_mm, axis=0).max():
        return InkMatch(np.full(len(on_paper), math.inf), on_paper, ink.points_mm)
    path = written_path_mm(tip_xy, pressed)
    if len(path) == 0:
        return None
    return match_ink(path, ink.map)


def _starting_shifts(path_mm: Array, ink_mm: Array) -> list[Array]:
    """Return the shift of the medians and a grid that keeps the path's extent within the ink's."""
    low = ink_mm.min(axis=0) - path_mm.min(axis=0)
    high = ink_mm.max(axis=0) - path_mm.max(axis=0)
    low, high = np.minimum(low, high) - STARTING_GRID_MM, np.maximum(low, high) + STARTING_GRID_MM
    x, y = (np.arange(low[i], high[i] + STARTING_GRID_MM, STARTING_GRID_MM) for i in range(2))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return [np.median(ink_mm, axis=0) - np.median(path_mm, axis=0), *grid]


def _settled_shift(
    path_mm: Array,
    nearest: Callable[[Array], Array],
    start: Array,
    rounds: int = ALIGNMENT_ROUNDS,
) -> Array:
    shift = start
    for _ in range(rounds):
        step = (nearest(path_mm + shift) - path_mm - shift).mean(axis=0)
        shift = shift + step
        if np.abs(step).max() < SETTLED_MM:
            break
    return np.asarray(shift)


def _mean_distance(points_mm: Array, nearest: Callable[[Array], Array]) -> float:
    return float(np.linalg.norm(nearest(points_mm) - points_mm, axis=1).mean())
