"""The arrival cost's evidence, a few runs of it."""

from __future__ import annotations

from suites.classics.arrival_cost import CONTENDERS, found

SEEDS = 4


def test_an_arrival_cost_at_the_windows_estimate_finds_what_an_ekf_does_not() -> None:
    counts = {
        label: found("gas_2A_to_B", estimator, chosen, SEEDS)
        for label, (estimator, chosen) in CONTENDERS.items()
    }
    for estimator in ("mhe", "mhe-rti", "mhe-rti, full passes"):
        assert counts[f"{estimator}, smoothed"] == SEEDS
    assert counts["ekf"] == counts["mhe, filtered"] < SEEDS
