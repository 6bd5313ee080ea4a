"""As much of a recording as checks look at, whatever its length: blocks, evenly spread."""

from __future__ import annotations

import numpy as np

from estimation.recording import Recording
from estimation.recording_parts import joined
from models.arrays import Array

BLOCK_ROWS, MOST_BLOCKS = 5_000, 24
"""All of a recording up to so many rows; of a longer one every second block, every fourth, …"""


class Sketch:
    """Keeps blocks of a recording whose parts pass by; memory does not grow with it."""

    def __init__(self) -> None:
        self._every, self._count, self._rows = 1, 0, 0
        self._kept: list[tuple[int, Recording]] = []
        self._open: list[Recording] = []

    def take(self, part: Recording) -> None:
        """Look at the next part."""
        start, n = 0, len(part.time_s)
        while start < n:
            end = min(n, start + BLOCK_ROWS - self._rows)
            if self._count % self._every == 0:
                self._open.append(part.some_rows(np.arange(start, end)))
            self._rows += end - start
            if self._rows == BLOCK_ROWS:
                self._close()
            start = end

    def _close(self) -> None:
        if self._open:
            block = joined(self._open) if len(self._open) > 1 else self._open[0]
            self._kept.append((self._count, block))
        self._open, self._rows = [], 0
        self._count += 1
        if len(self._kept) > MOST_BLOCKS:
            self._every *= 2
            self._kept = [(k, block) for k, block in self._kept if k % self._every == 0]

    def end(self) -> tuple[Recording, Array] | None:
        """Return what is kept, and (k,) the times after which something was left out.

        None where nothing came.
        """
        if self._open:
            self._close()
        if not self._kept:
            return None
        numbers, blocks = zip(*self._kept, strict=True)
        ends = [
            float(block.time_s[-1])
            for block, this, following in zip(blocks, numbers, numbers[1:], strict=False)
            if following != this + 1
        ]
        return joined(blocks), np.array(ends)
