"""A finding says where and when, so that a person finds it in a log."""

from __future__ import annotations

import pytest

from recordings.finding import Finding


@pytest.mark.parametrize(
    ("span_s", "words"),
    [
        ((0.0, 0.12339), "0 s to 0.1234 s"),
        ((5.32, 17.31), "5.32 s to 17.31 s"),
        ((88123.4, 88135.39), "88123.4 s to 88135.39 s"),
        ((1.7e9 + 0.125, 1.7e9 + 60), "1700000000.12 s to 1700000060 s"),
    ],
)
def test_times_are_those_of_the_log(span_s: tuple[float, float], words: str) -> None:
    found = Finding("it repeats a reading", "accel", 1.0, "look at it", span_s=span_s)
    assert found.place == f"accel, {words}"
