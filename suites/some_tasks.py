"""Some tasks of a suite, run here and kept nowhere: what a notebook shows of it."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmark.figures.matplotlib_figure import matplotlib_figure
from benchmark.runner.run import Workers
from benchmark.runner.tables import read_tables
from benchmark.tasks.results import Results
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import FAILED
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import NO_DATA, Judgement, judge
from benchmark.verdicts.paired import paired
from estimation.progress_bar import progress
from models.errors import InputError
from models.names import unknown
from suites.execute import run_suites
from suites.table import find_suite

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Wanted = tuple[str, str, str, int]
"""Case, sensors and estimator, each with ``*`` for anything, and how many seeds."""


@dataclass(frozen=True, eq=False)
class SuiteRun:
    """What `run_some` returns.

    Parameters
    ----------
    suite : whose tasks they were
    results : its tables
    tasks : how many there were
    """

    suite: Suite
    results: Results
    tasks: int

    @property
    def failed(self) -> Mapping[str, int]:
        """Why rows have no figures → how many."""
        rows = self.results.rows
        return Counter(map(str, rows.loc[rows["status"] == FAILED, "reason"]))

    def figure(self, key: str) -> Figure:
        """Return a figure of the suite's part of the report; raises `InputError` for no such."""
        known = {figure.key: figure for figure in self.suite.figures(self.results)}
        if key not in known:
            raise unknown("figure", key, known)
        return matplotlib_figure(known[key])

    def verdicts(self, ids: Sequence[str] = ("*",), *, source: str = "") -> pd.DataFrame:
        """Return the claims for which there are runs, with figures and verdicts.

        Parameters
        ----------
        ids : of those that are judged, each with ``*`` for anything
        source : how the sources of those that are judged begin: ``[Pen]``
        """
        import pandas as pd

        claims = () if self.suite.claims is None else load_claims(self.suite.claims)
        chosen = [
            claim
            for claim in claims
            if any(fnmatch(claim.id, id) for id in ids) and claim.source.startswith(source)
        ]
        return pd.DataFrame(
            {
                "source": judgement.claim.source,
                "claim": judgement.claim.says,
                "criterion": judgement.claim.criterion,
                **_figures_of(judgement),
                "verdict": judgement.verdict,
            }
            for judgement in judge(chosen, self.results.rows)
            if judgement.verdict != NO_DATA
        )

    def pairs(self, case: str, quantities: Sequence[str]) -> pd.DataFrame:
        """Return what an MHE differs from the EKF by on the same runs, per sensors and quantity.

        Parameters
        ----------
        case : with ``*`` for anything
        """
        rows = self.results.rows
        alike = rows["case"].map(lambda name: fnmatch(name, case))
        return paired(rows[alike & rows["quantity"].isin(quantities)]).drop(columns="suite")


def run_some(suite: str, wanted: Sequence[Wanted]) -> SuiteRun:
    """Run the tasks of a suite that are wanted, one after the other, with a bar of progress.

    Parameters
    ----------
    suite : name
    wanted : rows of case, sensors, estimator and the number of seeds; the largest counts where
        several fit

    Raises
    ------
    InputError
        If the suite is unknown, or no task is wanted.
    """
    found = find_suite(suite)
    scope = Scope(seeds=max((seeds for *_, seeds in wanted), default=0))

    def seeds_of(of_task: tuple[str, str, str]) -> int:
        return max((n for *row, n in wanted if all(map(fnmatch, of_task, row))), default=0)

    tasks = [
        task
        for task in found.tasks(scope)
        if task.seed < seeds_of((task.case, task.sensors, task.estimator))
    ]
    if not tasks:
        raise InputError(f"suite {suite} has none of the wanted tasks, expected some")
    with tempfile.TemporaryDirectory() as folder, progress(suite) as start:
        run_suites(tasks, scope, Workers(jobs=1), Path(folder), start)
        return SuiteRun(found, read_tables(Path(folder)), len(tasks))


def _figures_of(judgement: Judgement) -> dict[str, str]:
    """Return the figure of a claim and its interval; quantities of several units have no mean."""
    if not np.isfinite(judgement.figure):
        return {"figure": f"by quantity, {judgement.holding} hold", "95 % interval": ""}
    figure, low, high = (
        f"{value:.3g}" for value in (judgement.figure, judgement.low, judgement.high)
    )
    return {"figure": figure, "95 % interval": f"{low} to {high}"}
