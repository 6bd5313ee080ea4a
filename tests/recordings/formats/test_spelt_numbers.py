"""Cells of numbers as people spell them, each alone in a column of texts."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from recordings.foreign.spelt_numbers import respelt


@pytest.mark.parametrize(
    ("cell", "decimal", "number"),
    [
        ("−0.3", ".", -0.3),
        ("1.5D-03", ".", 1.5e-3),
        ("2d4", ".", 2e4),
        ("1,234.5", ".", 1234.5),
        ("1 234 567.5", ".", 1234567.5),
        ("1'234.5", ".", 1234.5),
        (",5", ",", 0.5),
        ("-,5", ",", -0.5),
        ("1.234,5", ",", 1234.5),
        ("−,25d1", ",", -2.5),
    ],
)
def test_a_column_of_one_spelling(cell: str, decimal: str, number: float) -> None:
    frame = pd.DataFrame({"x": [cell] * 3})
    assert np.allclose(respelt(frame, decimal)["x"].to_numpy(float), number, rtol=1e-15)


def test_words_stay() -> None:
    frame = pd.DataFrame({"x": ["accel", "gyro", None], "y": ["left", "a,b", "3 d"]})
    pd.testing.assert_frame_equal(respelt(frame, "."), frame)
