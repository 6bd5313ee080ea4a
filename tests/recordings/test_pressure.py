"""Pressure above a drifting baseline, by its definition, and by what it may not know."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from recordings.formats.dpoint import read_dpoint
from recordings.pressure import above_baseline

RNG = np.random.default_rng(0)
TIME_S = np.cumsum(RNG.uniform(0.005, 0.02, 500))
PRESSURE = RNG.uniform(0, 1, 500)


def test_it_is_the_lowest_of_the_window_behind() -> None:
    found = above_baseline(TIME_S, PRESSURE, 0.3)
    for k in (0, 1, 17, 250, 499):
        window = [
            p for t, p in zip(TIME_S, PRESSURE, strict=True) if TIME_S[k] - 0.3 <= t <= TIME_S[k]
        ]
        assert found[k] == PRESSURE[k] - min(window)


def test_what_comes_later_changes_nothing() -> None:
    changed = PRESSURE.copy()
    changed[301:] = -1.0
    now = above_baseline(TIME_S, changed, 1.0)
    np.testing.assert_array_equal(now[:301], above_baseline(TIME_S, PRESSURE, 1.0)[:301])


def test_a_drift_is_no_press() -> None:
    drift = 0.01 * TIME_S
    pressed = (TIME_S % 1) > 0.5
    above = above_baseline(TIME_S, drift + 0.1 * pressed, 2.0)
    late = TIME_S > 2
    np.testing.assert_array_equal(above[late] > 0.06, pressed[late])
    assert (drift[late] + 0.1 * pressed[late] > 0.06).sum() > pressed[late].sum()


def test_a_baseline_changes_a_frame_or_two_of_the_real_pen(dpoint_folder: Path) -> None:
    """Its baseline wanders by 0.003 only: 0.0165 before the pen writes, 0.0198 between strokes."""
    raw = read_dpoint(dpoint_folder, 0.045, 0.022)
    above = read_dpoint(dpoint_folder, 0.045, 0.0055, baseline_s=10.0)
    touches = raw.pressure > 0.022, above.pressure > 0.0055
    for read, pressed in zip((raw, above), touches, strict=True):
        times, _ = read.recording.sensor("contact")
        np.testing.assert_allclose(times, read.pressure_time_s[pressed], rtol=0, atol=1e-9)
    assert 0 < (touches[0] != touches[1]).mean() < 0.005
