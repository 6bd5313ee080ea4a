from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from classical_baseline.tilt_conversion import AdcConversion
from models.errors import InputError


def test_equations_by_hand() -> None:
    conversion = AdcConversion(zero_g_v=2.0, reference_v=5.0, sensitivity_v_per_g=0.5, bits=8)
    # 255 counts for 5 V: 102 counts are 2 V, 153 are 3 V, 51 are 1 V.
    assert conversion.acceleration_g([102, 153, 51]) == pytest.approx([0.0, 2.0, -2.0], abs=1e-14)
    assert conversion.counts([0.0, 2.0, -2.0]).tolist() == [102, 153, 51]


def test_published_figures() -> None:
    conversion = AdcConversion()
    assert conversion.largest_count == 65535
    at_most, at_least = conversion.acceleration_g([65535, 0])
    assert at_most == pytest.approx((5 - 1.65) / 0.4785)
    assert at_least == pytest.approx(-1.65 / 0.4785)


@given(st.lists(st.floats(-3, 6), min_size=1, max_size=9))
def test_there_and_back_is_within_half_a_step(acceleration: list[float]) -> None:
    conversion = AdcConversion()
    back = conversion.acceleration_g(conversion.counts(acceleration))
    assert np.abs(back - acceleration).max() <= conversion.step_g / 2 * (1 + 1e-9)


@given(st.lists(st.integers(0, 65535), min_size=1, max_size=9))
def test_back_and_there_is_exact(counts: list[int]) -> None:
    conversion = AdcConversion()
    assert conversion.counts(conversion.acceleration_g(counts)).tolist() == counts


def test_the_converter_stays_in_its_range() -> None:
    conversion = AdcConversion()
    assert conversion.counts([-100.0, 100.0, np.inf]).tolist() == [0, 65535, 65535]


@pytest.mark.parametrize("count", [-1, 65536, 0.5, np.nan])
def test_no_count_of_the_converter(count: float) -> None:
    with pytest.raises(InputError, match="whole number from 0 to 65535"):
        AdcConversion().acceleration_g([[0, 1, count]])


def test_no_acceleration_to_convert() -> None:
    with pytest.raises(InputError, match="is NaN"):
        AdcConversion().counts([0.0, np.nan])


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"sensitivity_v_per_g": 0.0}, "sensitivity_v_per_g is 0.0"),
        ({"reference_v": np.nan}, "reference_v is nan"),
        ({"bits": 2.5}, "bits is 2.5"),
        ({"bits": 64}, "bits is 64"),
        ({"zero_g_v": 6.0}, "zero_g_v is 6.0 V"),
    ],
)
def test_bad_settings(changed: dict[str, float], named: str) -> None:
    with pytest.raises(InputError, match=named):
        AdcConversion(**changed)  # type: ignore[arg-type]
