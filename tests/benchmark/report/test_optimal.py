"""IPOPT beside `mhe` in the report."""

from __future__ import annotations

from typing import Any

import pandas as pd

from benchmark.report.optimal import optima


def row(estimator: str, seed: int, step_s: float, quantity: str, rmse: float) -> dict[str, Any]:
    return {
        "suite": "pen", "case": "free", "sensors": "gyro", "estimator": estimator, "seed": seed,
        "quantity": quantity, "rmse": rmse, "max_error": 3 * rmse, "samples": 51,
        "solved_fraction": 1.0, "step_time_median_s": step_s, "status": "ok",
    }  # fmt: skip


def test_times_are_of_the_same_runs_and_the_worst_distance_stands() -> None:
    rows = [row("mhe", seed, 1e-3 * (1 + seed), "tip", 1.0) for seed in range(5)]
    rows += [row("mhe-ipopt", seed, 0.04, "tip", 1.0) for seed in range(2)]
    rows += [row("mhe-ipopt", seed, 0.04, "distance from mhe", 1e-8 + seed) for seed in range(2)]
    (found,) = optima(pd.DataFrame(rows))
    assert (found.case, found.sensors, found.runs, found.steps) == ("free", "gyro", 2, 51)
    assert (found.near_s, found.reference_s) == (1.5e-3, 0.04)
    assert (found.distance, found.largest) == (1 + 1e-8, 3 * (1 + 1e-8))
    assert optima(pd.DataFrame([row("mhe", 0, 1.0, "tip", 1.0)])) == []
