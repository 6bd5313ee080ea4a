"""Rows of an inequality that only instants with certain readings demand."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from models.errors import InputError
from tests.linear_models import coupled_system

MODEL = coupled_system(4).model
READINGS = ("first_0", "second_0", "second_1")
LOWER_HALF = MODEL.bounded(s0_m=(-np.inf, 0.0))


def test_the_readings_are_what_these_tests_take_them_for() -> None:
    assert MODEL.reading_names == READINGS


def test_without_needs_every_instant_demands() -> None:
    model = MODEL.constrained(lambda x: x[:2])
    assert model.conditions is None
    assert np.array_equal(model.inequality_needs, np.zeros((2, 3), dtype=bool))
    assert MODEL.constrained(lambda x: x[:2], needs=()).conditions is None


def test_needs_are_kept_row_by_row() -> None:
    model = MODEL.constrained(lambda x: x[0])
    model = model.constrained(lambda x: x[1:3], needs=["second_1", "first_0"])
    model = model.constrained(lambda x: x[3]).constrained(lambda x: x[0] - 1, needs="second_0")
    wanted = np.array([[0, 0, 0], [1, 0, 1], [1, 0, 1], [0, 0, 0], [0, 1, 0]], dtype=bool)
    assert model.conditions is not None
    assert np.array_equal(model.conditions, wanted)
    assert np.array_equal(model.inequality_needs, wanted)
    assert model.conditions.dtype == np.bool_
    assert MODEL.conditions is None


@pytest.mark.parametrize("needs", [("second_0", "lidar_x"), "lidar_x"])
def test_an_unknown_reading_is_refused(needs: Any) -> None:
    with pytest.raises(InputError) as error:
        MODEL.constrained(lambda x: x[0], needs=needs)
    assert str(error.value) == (
        "model linear: an inequality needs the unknown reading lidar_x; "
        "expected one of first_0, second_0, second_1"
    )


@pytest.mark.parametrize(
    "conditions",
    [
        np.zeros((1, 3), dtype=bool),
        np.zeros((2, 2), dtype=bool),
        np.zeros(6, dtype=bool),
        np.zeros((2, 3)),
    ],
    ids=["rows", "readings", "flat", "numbers"],
)
def test_conditions_are_checked(conditions: Any) -> None:
    model = MODEL.constrained(lambda x: x[:2])
    with pytest.raises(InputError, match=r"conditions have shape .*, expected \(2, 3\) of bool"):
        model.replace(conditions=conditions)


def test_rows_that_no_instant_need_demand_together_may_contradict_each_other() -> None:
    model = LOWER_HALF.constrained(lambda x: x[1] + 1, needs=["first_0"])
    model = model.constrained(lambda x: 1 - x[1], needs=["second_0"])
    assert model.inequality.numel_out(0) == 2
    assert model.bounded(s1_m=(-5.0, 5.0)).lower[1] == -5


IMPOSSIBLE = {
    "a bound": (
        LOWER_HALF,
        "row 1 of the inequality ((1-s0_m) <= 0 where there is first_0) and the bound on s0_m",
    ),
    "a row that is always demanded": (
        MODEL.constrained(lambda x: x[0]),
        "row 1 of the inequality (s0_m <= 0) and row 2 of the inequality ((1-s0_m) <= 0 where "
        "there is first_0), expected",
    ),
    "a row with the same condition": (
        MODEL.constrained(lambda x: x[0], needs=["first_0"]),
        "row 1 of the inequality (s0_m <= 0 where there is first_0) and row 2 of the inequality "
        "((1-s0_m) <= 0 where there is first_0), expected",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_row_that_never_can_be_met_where_it_is_demanded_is_refused(name: str) -> None:
    model, demands = IMPOSSIBLE[name]
    with pytest.raises(InputError, match=re.escape(f"model linear: no state meets {demands}")):
        model.constrained(lambda x: 1 - x[0], needs=["first_0"])


def test_a_row_with_more_conditions_meets_those_with_fewer() -> None:
    """Where first_0 and second_0 are there, rows that need either are demanded too."""
    model = MODEL.constrained(lambda x: x[0], needs=["first_0"])
    assert model.constrained(lambda x: 1 - x[0], needs=["second_0"]).conditions is not None
    with pytest.raises(InputError, match=r"where there is first_0 and second_1\), expected"):
        model.constrained(lambda x: 1 - x[0], needs=["first_0", "second_1"])


def test_the_fewest_conditions_are_told_first() -> None:
    """The unconditional conflict is named, not one of a row that has nothing to do with it."""
    model = MODEL.constrained(lambda x: x[1] + 1, needs=["first_0"])
    with pytest.raises(InputError) as error:
        model.constrained(lambda x: x[0]).constrained(lambda x: 1 - x[0])
    assert "row 2 of the inequality (s0_m <= 0) and row 3" in str(error.value)
    assert "first_0" not in str(error.value)
