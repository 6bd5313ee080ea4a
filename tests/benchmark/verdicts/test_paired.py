"""One estimator against another on the same runs."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmark.verdicts.paired import BETTER, EQUAL, SAME, WORSE, paired
from tests.benchmark.verdicts.results_table import seeds, table

EKF = [10.0, 12.0, 8.0, 11.0, 9.0]


def against(mhe: list[float], **row: object) -> pd.Series:
    """What is said of two estimators on one case, five seeds."""
    found = paired(table(*seeds(EKF, **row), *seeds(mhe, estimator="mhe", **row)))
    assert len(found) == 1
    return found.iloc[0]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ([-1, -2, -1, -2, -1], BETTER),
        ([1, 2, 1, 2, 1], WORSE),
        ([-3, 3, -3, 3, 0.5], EQUAL),
        ([0.05, -0.05, 0.1, -0.1, 0.02], SAME),
        ([0, 0, 0, 0, 0], SAME),
    ],
)
def test_the_sign_and_what_it_means(change: list[float], expected: str) -> None:
    row = against([a + b for a, b in zip(EKF, change, strict=True)])
    assert row["verdict"] == expected
    assert row["difference"] == pytest.approx(np.mean(change))
    assert row["low"] <= row["difference"] <= row["high"]
    assert (row["ekf"], row["pairs"]) == (10.0, 5)
    assert row["mhe"] == pytest.approx(10.0 + np.mean(change))
    assert list(row[["suite", "sensors", "quantity", "unit"]]) == ["pen", "accel", "tip", "mm"]


def test_only_what_can_be_seen_and_ended_well_counts() -> None:
    blind = table(*seeds(EKF, observable=False), *seeds(EKF, estimator="mhe", observable=False))
    assert len(paired(blind)) == 0
    assert (
        list(paired(blind))
        == list(paired(table()))
        == [
            *("suite", "sensors", "quantity", "unit", "ekf", "mhe", "difference"),
            *("low", "high", "pairs", "verdict"),
        ]
    )
    rows = table(
        *seeds([*EKF, 1.0, 1.0, np.inf, 1.0]),
        *seeds([*EKF, np.nan, np.inf, 1.0], estimator="mhe"),
        {"estimator": "mhe", "seed": 8, "rmse": 900.0, "status": "mirror"},
    )
    row = paired(rows).iloc[0]
    assert (row["pairs"], row["difference"], row["verdict"]) == (5, 0.0, SAME)


def test_groups_and_other_estimators() -> None:
    rows = table(
        *(row for case in "ab" for row in seeds(EKF, case=case)),
        *(row for case in "ab" for row in seeds(EKF, case=case, estimator="mhe-rti")),
        *seeds(EKF, sensors="gyro", quantity="rates", unit="deg/s"),
        *seeds(EKF, sensors="gyro", quantity="rates", unit="deg/s", estimator="mhe"),
    )
    assert list(paired(rows)["sensors"]) == ["gyro"]
    found = paired(rows, other="mhe-rti")
    assert list(found["sensors"]) == ["accel"]
    assert (found["pairs"].item(), found["mhe-rti"].item()) == (10, 10.0)


def test_the_order_of_the_rows_does_not_matter() -> None:
    rng = np.random.default_rng(0)
    rows = table(
        *(row for case in "ab" for row in seeds(list(rng.uniform(1, 3, 6)), case=case)),
        *(row for case in "ab"
          for row in seeds(list(rng.uniform(1, 3, 6)), case=case, estimator="mhe")),
    )  # fmt: skip
    first = paired(rows)
    assert first["low"].item() < first["difference"].item() < first["high"].item()
    pd.testing.assert_frame_equal(paired(rows.sample(frac=1, random_state=1)), first)
