"""`mhe` with active bounds and inequalities ends in the optimum: IPOPT's, and OSQP's."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests.mhe.bounded_cases import CASES
from tests.mhe.bounded_comparison import BoundedRow, compare, listed
from tests.mhe.bounded_windows import (
    HORIZONS,
    PLACEMENTS,
    TOUCHING,
    bounded_table,
)

LONGEST = {"dpoint": 3, "pen in a circle": 3, "pen15": 8}
"""Horizons of what is slow to build, here; all are among the thousand windows."""
QUICK = [
    key
    for key in bounded_table(len(PLACEMENTS) * len(HORIZONS) * len(CASES))[:64]
    if key.horizon <= LONGEST.get(key.case, max(HORIZONS))
]
WINDOWS = 1000
MOST_OTHERS = 0.01
"""Of windows that end in another minimum than IPOPT's."""


def check(rows: Sequence[BoundedRow]) -> None:
    """All are optimal, and almost all are IPOPT's."""
    missed = [row for row in rows if not row.is_optimal]
    assert not missed, listed(missed)
    others = [row for row in rows if not row.is_ipopts]
    apart = [row for row in others if not row.is_other_minimum]
    assert not apart, listed(apart)
    assert len(others) <= MOST_OTHERS * len(rows), listed(others)


@pytest.mark.slow
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_the_optimum_with_active_rows(placement: str) -> None:
    rows = [compare(key) for key in QUICK if key.placement == placement]
    check(rows)
    assert {row.key.case for row in rows} == set(CASES)
    if placement == TOUCHING:
        assert sum(row.weak for row in rows) >= 3, listed(rows)
    else:
        assert all(row.active for row in rows), listed(rows)
        assert sum(row.active >= 3 for row in rows) >= 3, listed(rows)
        assert not any(row.weak for row in rows), listed(rows)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_optimum_with_active_rows_on_a_thousand_windows(case: str) -> None:
    """A thousand over all cases: an eighth of them here."""
    keys = [key for key in bounded_table(WINDOWS) if key.case == case]
    assert len(keys) == WINDOWS // len(CASES)
    rows = [compare(key) for key in keys]
    check(rows)
    assert sum(row.active > 0 for row in rows) >= 0.7 * len(rows)
    assert any(row.weak for row in rows)
    assert any(row.active > 1 for row in rows)
