"""An arrival cost of an EKF against one at the window's estimate, on problems of the suite.

Run as ``python -m suites.classics.arrival_cost [SEEDS]``; what it says is in
``docs/arrival_cost.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from suites.classics.contender import OwnContender
from suites.classics.recordings import prior_of, recorded
from suites.classics.run import RUN_WITHIN, SUCCESS, quantities

SUCCEEDS = MappingProxyType(
    {
        "gas_2A_to_B": SUCCESS,
        "gas_A_B_C": SUCCESS,
        "van_der_pol": RUN_WITHIN,
        "rotating_masses": SUCCESS,
    }
)
"""Case → the quantity that is 1 for a run that finds the truth."""

CONTENDERS: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType(
    {"ekf": ("ekf", {})}
    | {
        f"{label}, {arrival}": (estimator, {"arrival_cost": arrival, **more})
        for arrival in ("filtered", "smoothed")
        for label, estimator, more in (
            ("mhe-rti", "mhe-rti", {}),
            ("mhe-rti, full passes", "mhe-rti", {"reuse_threshold": 0.0}),
            ("mhe", "mhe", {}),
        )
    }
)
"""Label → estimator and its settings beside N."""


def found(case: str, estimator: str, chosen: Mapping[str, Any], seeds: int) -> int:
    """Return in how many runs an estimator finds the truth."""
    contender, count = OwnContender(estimator, case, **chosen), 0
    for seed in range(seeds):
        recording = recorded(case, seed)
        prior = prior_of(case, recording, seed)
        told = quantities(case, recording, prior, contender.estimates(recording, prior))
        count += int(next(each.bias for each in told if each.name == SUCCEEDS[case]))
    return count


def main(seeds: int) -> None:
    """Print a row per problem and estimator."""
    for case in SUCCEEDS:
        for label, (estimator, chosen) in CONTENDERS.items():
            count = found(case, estimator, chosen, seeds)
            print(f"{case:16s} {label:32s} {count} of {seeds}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
