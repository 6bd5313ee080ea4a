"""Windows in a row of stamps, against a loop over them."""

from __future__ import annotations

import numpy as np

from recordings.window_rows import longest_gaps_s, window_rows, window_starts

LENGTH_S = 1.0


def test_as_by_a_loop() -> None:
    draw = np.random.default_rng(3)
    # Windows without a sample, with one, and with a gap at either end or between.
    time_s = np.sort(np.concatenate([draw.uniform(0, 20, 60), [30.2, 35.0, 35.9]]))
    start_s = np.arange(-2.0, 40.0, 0.5)
    gaps_s = longest_gaps_s(time_s, start_s, LENGTH_S)
    rows = window_rows(time_s, start_s, LENGTH_S)
    for start, gap_s, here in zip(start_s, gaps_s, rows, strict=True):
        inside = [t for t in time_s if start <= t < start + LENGTH_S]
        assert list(time_s[here]) == inside
        assert gap_s == np.diff([start, *inside, start + LENGTH_S]).max()


def test_without_samples() -> None:
    assert list(longest_gaps_s(np.zeros(0), np.array([0.0, 1.0]), LENGTH_S)) == [1.0, 1.0]


def test_windows_begin_where_there_are_samples() -> None:
    time_s = np.array([0.2, 0.3, 1.4, 7.0])
    assert list(window_starts(time_s, LENGTH_S, most=9)) == [0.2, 1.2, 6.7]
    many = np.arange(0.0, 50.0, 0.1)
    some = window_starts(many, LENGTH_S, most=10)
    assert len(some) == 10
    assert (some[0], some[-1]) == (0.0, 49.5)
    assert set(some) < set(np.arange(0.0, 50.0, 0.5))
