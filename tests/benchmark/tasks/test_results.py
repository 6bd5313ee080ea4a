"""Tables of a run: choosing rows and lines."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results

ROWS = pd.DataFrame(
    [{"suite": suite, "case": case, "seed": seed}
     for suite in ("pen", "tilt") for case in ("a", "b") for seed in (0, 1)],
    columns=list(RESULT_COLUMNS),
)  # fmt: skip
SERIES = pd.concat(
    pd.DataFrame(
        {"suite": "pen", "case": "a", "sensors": "accel", "estimator": name, "seed": 0,
         "quantity": "tip", "unit": "mm", "time_s": [0.0, 1.0], "estimate": [1.0, np.nan],
         "std": std, "truth": [5.0, 6.0]}
    )
    for name, std in (("ekf", 0.5), ("classical", np.nan))
)[list(SERIES_COLUMNS)]  # fmt: skip
RESULTS = Results(ROWS, SERIES)


def test_rows_are_chosen_by_values_or_lists_of_them() -> None:
    assert len(RESULTS.select()) == 8
    assert len(RESULTS.select(suite="pen", case=["a", "b"], seed=1)) == 2
    assert len(RESULTS.select(case=("a", "c"))) == 4
    assert len(RESULTS.select(case="c")) == 0
    assert set(RESULTS.of("tilt").rows["suite"]) == {"tilt"}
    assert len(RESULTS.of("tilt").series) == 0
    assert len(RESULTS.of("pen").series) == 4


def test_a_line_has_a_band_where_the_estimator_claims_one() -> None:
    ekf = RESULTS.lines("EKF", estimator="ekf", quantity="tip")
    assert ekf is not None
    assert (ekf.name, list(ekf.x)) == ("EKF", [0.0, 1.0])
    assert np.array_equal(ekf.y, [1.0, np.nan], equal_nan=True)
    assert ekf.std is not None
    assert list(ekf.std) == [0.5, 0.5]
    classical = RESULTS.lines("classical", estimator="classical")
    assert classical is not None
    assert classical.std is None
    truth = RESULTS.lines("truth", True, estimator="ekf")
    assert truth is not None
    assert (list(truth.y), truth.std) == ([5.0, 6.0], None)
    assert RESULTS.lines("EKF", estimator="mhe") is None
