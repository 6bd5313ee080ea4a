"""What a figure draws of a long run: few rows, evenly spread, from the first to nearly the last."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.recording import Truth
from pen_mhe.streaming.drawn import DrawnRows


@pytest.mark.parametrize("part", [1, 7, 50])
def test_a_long_truth_is_spread(monkeypatch: pytest.MonkeyPatch, part: int) -> None:
    monkeypatch.setattr("pen_mhe.streaming.drawn.MOST_DRAWN", 20)
    drawn, time_s = DrawnRows(), np.arange(300.0)
    for start in range(0, 300, part):
        times = time_s[start : start + part]
        drawn.read(Truth(times, ("x",), times[:, None]))
    kept = drawn.truth
    assert kept is not None
    np.testing.assert_array_equal(kept.time_s, time_s[:: int(kept.time_s[1])])
    assert 10 <= len(kept.time_s) <= 20
    np.testing.assert_array_equal(kept.values[:, 0], kept.time_s)
