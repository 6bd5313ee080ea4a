"""What the suite found, read again from the rows of its results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from benchmark.tasks.results import Results
from suites.speed.cases import CASES
from suites.speed.outcomes import named

NAN = float("nan")


@dataclass(frozen=True)
class Found:
    """What a contender found in a race.

    Parameters
    ----------
    case, contender : which
    figures : quantity → figure
    says : version and clocks
    """

    case: str
    contender: str
    figures: Mapping[str, float]
    says: str

    @property
    def modes(self) -> list[str]:
        """What it did with an item, in the order of its entries."""
        return list(dict.fromkeys(name.rpartition(": ")[0] for name in self.figures if ":" in name))

    def figure(self, mode: str, figure: str) -> float:
        """Return a figure of a mode; NaN where there is none."""
        return self.figures.get(named(mode, figure), NAN)


def found_in(results: Results) -> list[Found]:
    """Return what all contenders that ran found, race by race."""
    rows = results.rows[results.rows["quantity"] != ""]
    gathered: dict[tuple[str, str], dict[str, float]] = {}
    says: dict[tuple[str, str], str] = {}
    for row in rows.to_dict("records"):
        who = str(row["case"]), str(row["estimator"])
        gathered.setdefault(who, {})[str(row["quantity"])] = float(row["bias"])
        says[who] = str(row["reason"])
    order = [(case, name) for case, race in CASES.items() for name in race.names]
    return [Found(*who, gathered[who], says[who]) for who in order if who in gathered]
