"""Verdicts on tables whose answer is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.verdicts.bootstrap import Interval
from benchmark.verdicts.judge import (
    FAILS,
    HOLDS,
    NO_DATA,
    NOT_JUDGED,
    UNDECIDED,
    Judgement,
    judge,
    verdict,
)
from tests.benchmark.verdicts.results_table import claim, seeds, table


def one(rows: pd.DataFrame, **fields: Any) -> Judgement:
    (found,) = judge([claim(**fields)], rows)
    return found


@pytest.mark.parametrize(
    ("least", "most", "low", "high", "expected"),
    [
        (None, 1.0, 0.5, 1.0, HOLDS),
        (None, 1.0, 0.5, 1.1, UNDECIDED),
        (None, 1.0, 1.1, 1.2, FAILS),
        (1.0, None, 1.0, 1.2, HOLDS),
        (1.0, None, 0.9, 1.2, UNDECIDED),
        (1.0, None, 0.8, 0.9, FAILS),
        (0.9, 1.1, 0.9, 1.1, HOLDS),
        (0.9, 1.1, 0.8, 1.2, UNDECIDED),
        (0.9, 1.1, 1.2, np.inf, FAILS),
        (2.0, None, np.inf, np.inf, HOLDS),
        (None, 2.0, np.inf, np.inf, FAILS),
        (None, 2.0, np.nan, np.nan, UNDECIDED),
    ],
)
def test_the_whole_interval_decides(
    least: float | None, most: float | None, low: float, high: float, expected: str
) -> None:
    of = claim(at_least=least, at_most=most)
    assert verdict(of, Interval(low, low, high)) == expected


def test_ratio_and_difference_of_pairs() -> None:
    rows = table(
        *seeds([2.0, 4.0, 6.0]),
        *seeds([1.0, 3.0, 8.0], estimator="mhe"),
        *seeds([100.0] * 3, estimator="mhe-rti"),
    )
    fields: dict[str, Any] = {
        "of": {"estimator": "mhe"}, "against": {"estimator": "ekf"}, "at_most": 1.5,
    }  # fmt: skip
    ratio = one(rows, **fields)
    assert (ratio.figure, ratio.pairs) == (12 / 12, 3)
    # The resamples of three pairs, all of them: the extremes are three times the same pair.
    assert (ratio.low, ratio.high) == (1 / 2, 8 / 6)
    assert ratio.verdict == HOLDS
    difference = one(rows, **fields, compare="difference")
    assert (difference.figure, difference.low, difference.high) == (0.0, -1.0, 2.0)
    assert difference.verdict == UNDECIDED


def test_pairs_are_of_one_recording() -> None:
    """Errors that differ more between seeds than between estimators: the pairing decides."""
    of_seed = np.random.default_rng(0).uniform(1, 100, 10)
    rows = table(*seeds(list(of_seed)), *seeds(list(of_seed - 0.1), estimator="mhe")).sample(
        frac=1, random_state=0
    )
    found = one(
        rows,
        of={"estimator": "mhe"},
        against={"estimator": "ekf"},
        compare="difference",
        at_most=0.0,
    )
    assert found.verdict == HOLDS
    assert (found.low, found.figure, found.high) == pytest.approx((-0.1, -0.1, -0.1))


def test_sensors_are_paired_with_themselves() -> None:
    """Also where what there is to compare with is there for one of them only."""
    both = [
        *seeds([1.0, 1.0], estimator="mhe", sensors="accel"),
        *seeds([8.0, 8.0], estimator="mhe", sensors="gyro"),
        *seeds([4.0, 4.0], sensors="gyro"),
    ]
    fields: dict[str, Any] = {
        "of": {"estimator": "mhe"}, "against": {"estimator": "ekf"}, "at_least": 1,
    }  # fmt: skip
    found = one(table(*both), **fields)
    assert (found.figure, found.pairs) == (2.0, 2)
    found = one(table(*both, *seeds([2.0, 2.0], sensors="accel")), **fields)
    assert (found.figure, found.pairs) == (9 / 6, 4)


def test_against_another_case_or_quantity() -> None:
    rows = table(
        *seeds([3.0, 5.0], case="bad"),
        *seeds([1.0, 2.0], case="good"),
        *seeds([9.0, 9.0], case="good", quantity="elevation"),
    )
    fields: dict[str, Any] = {"against": {"case": "good"}, "compare": "difference", "at_most": 9}
    found = one(rows, of={"case": "bad"}, **fields)
    assert (found.figure, found.pairs) == (2.5, 2)
    found = one(
        rows,
        of={"case": "good", "quantity": "elevation"},
        against={"quantity": "tip"},
        compare="ratio",
        at_most=9,
    )
    assert found.figure == 18 / 3


def test_every_part_must_hold_by_itself() -> None:
    rows = table(
        *seeds([1.0, 1.0], case="a"), *seeds([1.0, 1.1], case="b"), *seeds([3.0, 3.0], case="c")
    )
    found = one(rows, every=["case"], at_most=2.0)
    assert [(part.name, part.figure, part.verdict) for part in found.parts] == [
        ("a", 1.0, HOLDS),
        ("b", 1.05, HOLDS),
        ("c", 3.0, FAILS),
    ]
    assert (found.verdict, found.holding, found.pairs) == (FAILS, "2 of 3", 6)
    assert found.figure < 2.0  # over everything it would hold
    assert one(rows, at_most=2.0).verdict == HOLDS
    assert one(rows, at_most=2.0).holding == ""
    wide = table(*seeds([1.0, 1.0], case="a"), *seeds([1.0, 9.0], case="b"))
    assert one(wide, every=["case"], at_most=2.0).verdict == UNDECIDED
    assert one(wide, every=["case", "sensors"], at_most=9.0).parts[1].name == "b, accel"


def test_a_pattern_chooses_what_fits() -> None:
    rows = table(
        *({"case": name, "rmse": value}
          for name, value in (("principle: dot", 1.0), ("principle: rise", 3.0), ("rest", 9.0),
                              ("compound: turn", 7.0)))
    )  # fmt: skip
    figures = {
        pattern: one(rows, of={"case": pattern}, at_most=1).figure
        for pattern in ("principle: *", "rest", "*: *e*", "*")
    }
    assert figures == {"principle: *": 2.0, "rest": 9.0, "*: *e*": 3.0, "*": 5.0}
    assert one(rows, of={"case": ("rest", "comp*")}, at_most=1).figure == 8.0
    assert one(rows, of={"case": "Rest"}, at_most=1).verdict == NO_DATA


def test_only_runs_that_are_ok_have_errors_and_all_have_a_status() -> None:
    rows = table(
        *seeds([1.0, 2.0]),
        {"seed": 2, "rmse": 50.0, "status": "mirror", "solved_fraction": 0.5},
        {"seed": 3, "rmse": np.nan, "quantity": "", "status": "failed", "solved_fraction": 0.0},
        # A run with two quantities is one run.
        {"seed": 2, "rmse": 1.0, "status": "mirror", "solved_fraction": 0.5, "quantity": "tilt"},
    )
    errors = one(rows, at_most=9)
    assert (errors.figure, errors.pairs) == (1.5, 2)
    mirrors = one(rows, value="status=mirror", at_most=1)
    assert (mirrors.figure, mirrors.pairs) == (1 / 4, 4)
    broken = one(rows, value="status=failed", at_most=1)
    assert (broken.figure, broken.pairs) == (1 / 4, 4)
    solved = one(rows, value="solved_fraction", at_least=0.5)
    assert (solved.figure, solved.pairs) == (2.5 / 4, 4)


def test_fractions_are_compared_run_by_run() -> None:
    def rows_of(estimator: str, statuses: str) -> list[dict[str, Any]]:
        return [
            {"seed": seed, "estimator": estimator, "status": "mirror" if s == "m" else "ok"}
            for seed, s in enumerate(statuses)
        ]

    found = one(
        table(*rows_of("ekf", "mm.m"), *rows_of("mhe", "m...")),
        of={"estimator": "mhe"},
        against={"estimator": "ekf"},
        value="status=mirror",
        compare="difference",
        at_most=0,
    )
    assert (found.figure, found.pairs, found.verdict) == (-0.5, 4, HOLDS)


def test_infinite_and_missing_values(recwarn: pytest.WarningsRecorder) -> None:
    never = table(*seeds([1.0, 1.0, np.inf, np.nan]))
    found = one(never, at_most=2.0)
    assert (found.figure, found.pairs) == (np.inf, 3)
    assert found.verdict == UNDECIDED  # 30 % of the resamples have no infinite one
    assert one(never, at_most=2.0, statistic="median").figure == 1.0
    assert one(table(*seeds([np.inf] * 3)), at_most=2.0).verdict == FAILS
    both = table(*seeds([np.inf] * 3), *seeds([np.inf] * 3, estimator="mhe"))
    fields: dict[str, Any] = {"of": {"estimator": "mhe"}, "against": {"estimator": "ekf"}}
    for compare in ("ratio", "difference"):
        found = one(both, **fields, compare=compare, at_most=1.0)
        assert found.verdict == UNDECIDED
        assert np.isnan(found.figure)
    less = table(*seeds([np.inf] * 3), *seeds([1.0] * 3, estimator="mhe"))
    assert one(less, **fields, at_most=0.5).verdict == HOLDS
    zero = table(*seeds([0.0] * 3), *seeds([1.0] * 3, estimator="mhe"))
    assert one(zero, **fields, at_most=0.5).verdict == FAILS
    assert not recwarn.list


def test_the_worst_seed_of_every_cell() -> None:
    rows = table(
        *seeds([0.0, 1.0, 0.0, 0.0], case="a"),
        *seeds([0.0, 0.0, 0.0, 0.0], case="b"),
        *seeds([1.0, 1.0, 1.0, 1.0], case="c"),
        *seeds([0.0, 0.0, 0.0, 0.0], case="d"),
    )
    assert one(rows, at_most=1.0).figure == pytest.approx(5 / 16)
    found = one(rows, at_most=1.0, statistic="worst")
    assert (found.figure, found.pairs) == (0.5, 16)
    assert (found.low, found.high) == (0.25, 0.5)  # three in ten resamples of a lack its 1
    assert one(rows, at_most=0.5, statistic="worst").verdict == HOLDS
    assert one(rows, at_most=0.4, statistic="worst").verdict == UNDECIDED
    parts = one(rows, at_most=0.4, statistic="worst", every=["case"]).parts
    assert [part.figure for part in parts] == [1.0, 0.0, 1.0, 0.0]


def test_no_rows_are_no_verdict() -> None:
    assert one(table(), at_most=1).verdict == NO_DATA
    found = one(table(*seeds([1.0])), of={"estimator": "mhe"}, at_most=1, every=["case"])
    assert (found.verdict, found.pairs, found.parts) == (NO_DATA, 0, ())
    assert np.isnan([found.figure, found.low, found.high]).all()
    alone = one(
        table(*seeds([1.0])), against={"estimator": "mhe"}, of={"estimator": "ekf"}, at_most=1
    )
    assert alone.verdict == NO_DATA


def test_one_seed_is_its_own_interval_and_not_judged() -> None:
    rows = table(*seeds([1.5]))
    found = one(rows, at_most=2)
    assert (found.low, found.figure, found.high, found.verdict) == (1.5, 1.5, 1.5, NOT_JUDGED)
    for margin, said in ((0.3, HOLDS), (0.4, UNDECIDED)):
        assert one(rows, at_most=2, margin=margin).verdict == said
    assert one(rows, at_most=1, margin=0.3).verdict == FAILS
    assert one(table(*seeds([1.5, 1.5])), at_most=2, margin=0.4).verdict == HOLDS


def test_a_single_run_among_parts_decides_nothing() -> None:
    rows = table(*seeds([1.0, 1.1], case="a"), *seeds([9.0], case="b"))
    found = one(rows, every=["case"], at_most=2.0)
    assert [part.verdict for part in found.parts] == [HOLDS, NOT_JUDGED]
    assert (found.verdict, found.holding) == (HOLDS, "1 of 1")
    alone = one(table(*seeds([9.0])), every=["case"], at_most=2.0)
    assert (alone.verdict, alone.holding) == (NOT_JUDGED, "0 of 0")


def test_a_claim_that_says_why_it_is_not_judged() -> None:
    found = one(table(*seeds([1.0, 1.1])), at_most=2.0, not_judged="it cannot fail")
    assert (found.verdict, found.figure, found.parts) == (NOT_JUDGED, 1.05, ())


def test_quantities_of_different_units_have_no_mean() -> None:
    rows = table(
        *seeds([1.0, 1.1], quantity="tip", unit="mm"),
        *seeds([3.0, 3.0], quantity="tilt", unit="deg"),
    )
    found = one(rows, every=["quantity"], at_most=2.0)
    assert np.isnan([found.figure, found.low, found.high]).all()
    assert (found.verdict, found.holding, found.pairs) == (FAILS, "1 of 2", 4)


def test_the_order_of_the_rows_does_not_matter() -> None:
    rng = np.random.default_rng(2)
    rows = table(
        *(row for case in "abc" for row in seeds(list(rng.uniform(1, 3, 6)), case=case)),
        *(row for case in "abc"
          for row in seeds(list(rng.uniform(1, 3, 6)), case=case, estimator="mhe")),
    )  # fmt: skip
    fields: dict[str, Any] = {
        "of": {"estimator": "mhe"}, "against": {"estimator": "ekf"}, "every": ["case"],
        "at_most": 1,
    }  # fmt: skip
    first = one(rows, **fields)
    assert first.low < first.figure < first.high
    for _ in range(2):
        assert one(rows.sample(frac=1, random_state=3), **fields) == first
