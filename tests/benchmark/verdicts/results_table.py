"""Rows of results, typed by hand."""

from __future__ import annotations

from typing import Any

import pandas as pd

from benchmark.tasks.results import RESULT_COLUMNS
from benchmark.verdicts.claims import Claim

ROW: dict[str, Any] = {
    "suite": "pen", "case": "a", "model": "m", "sensors": "accel", "estimator": "ekf", "seed": 0,
    "quantity": "tip", "unit": "mm", "rmse": 1.0, "bias": 0.5, "max_error": 2.0,
    "observable": True, "claimed": 1.5, "samples": 9, "solved_fraction": 1.0,
    "step_time_median_s": 1e-3, "step_time_p99_s": 2e-3, "status": "ok", "reason": "",
}  # fmt: skip


def table(*rows: dict[str, Any]) -> pd.DataFrame:
    """Rows with all columns, from what is special of each."""
    made = pd.DataFrame([{**ROW, **row} for row in rows], columns=list(RESULT_COLUMNS))
    return made.astype({"rmse": float, "solved_fraction": float})


def seeds(values: list[float], **row: Any) -> list[dict[str, Any]]:
    """A row per seed, with its RMSE."""
    return [{**row, "seed": seed, "rmse": value} for seed, value in enumerate(values)]


def claim(**fields: Any) -> Claim:
    """A claim about everything, from what is special of it."""
    return Claim.model_validate(
        {"id": "c", "source": "ours", "says": "s", "criterion": "c", "of": {}, **fields}
    )
