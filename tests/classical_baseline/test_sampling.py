"""Even sampling is taken for granted by nobody."""

from __future__ import annotations

import numpy as np
import pytest

from classical_baseline.sampling import even_step
from models.errors import InputError


def test_the_step_of_even_samples() -> None:
    assert even_step(3.0 + 0.005 * np.arange(7)) == pytest.approx(0.005, rel=1e-12)


def test_a_little_jitter_is_no_gap() -> None:
    jitter = np.array([0.0, 1.0, -1.0, 1.0, 0.0]) * 1e-4
    assert even_step(0.016 * np.arange(5) + jitter) == pytest.approx(0.016)


@pytest.mark.parametrize(
    ("time_s", "message"),
    [
        ([0.0, 0.1, 0.2, 0.4], "step to sample 3 is 0.2 s"),
        ([0.0, 0.1, 0.2, 0.31], "step to sample 3 is 0.11 s"),
        ([0.0], "got 1 samples, expected at least 2"),
        ([0.0, 0.0], "expected even samples"),
        ([0.0, np.nan, 1.0], "expected even samples"),
    ],
)
def test_gaps_are_refused(time_s: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        even_step(np.array(time_s))
