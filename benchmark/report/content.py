"""What the report says, before it is a page or text."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmark.configurations import CONFIGURATIONS
from benchmark.figures.figure import Figure, Table
from benchmark.report.advice import Advice, advice
from benchmark.report.belief import costs_of_belief
from benchmark.report.broken import Broken, broken_off
from benchmark.report.choice import CONVERGED, SIMPLE
from benchmark.report.cost import Cost, costs
from benchmark.report.made_with import made_with
from benchmark.report.matrix import (
    MATRIX,
    NO_SPIN,
    Matrix,
    configurations_of,
    in_order,
    matrices,
    own_selections,
)
from benchmark.report.optimal import Optimum, optima
from benchmark.tasks.results import TASK_COLUMNS, Results
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Task
from benchmark.verdicts.claims import load_claims
from benchmark.verdicts.judge import VERDICTS, Judgement, judge
from benchmark.verdicts.paired import paired
from benchmark.verdicts.written import Origin, criteria_written

if TYPE_CHECKING:
    import pandas as pd

TITLE = "Which sensors, which estimator?"
PAPERS_WORLD = "The paper's world: a pen that cannot spin"

SYMBOLS: Mapping[str, str] = dict(zip(VERDICTS, ("✓", "✗", "?", "○", "–"), strict=True))
"""Verdict → the sign beside it."""


@dataclass(frozen=True)
class Answer:
    """One quantity's matrix and what follows from it."""

    matrix: Matrix
    advice: Advice


@dataclass(frozen=True)
class Comparison:
    """A row of `benchmark.verdicts.paired.paired`: the EKF against the MHE."""

    sensors: str
    quantity: str
    unit: str
    simple: float
    optimising: float
    difference: float
    low: float
    high: float
    pairs: int
    verdict: str


@dataclass(frozen=True, eq=False)
class ReportPart:
    """A suite's part of the report.

    Parameters
    ----------
    missing : why there is less than there could be, or nothing; empty otherwise
    command : that makes its results again
    written : claim → the commit of its criterion; empty outside a checkout
    """

    name: str
    anchor: str
    title: str
    summary: str
    missing: str
    command: str
    tasks: int
    figures: Sequence[Figure]
    tables: Sequence[Table]
    judgements: Sequence[Judgement]
    comparisons: Sequence[Comparison]
    broken: Sequence[Broken]
    written: Mapping[str, Origin]

    def counts(self) -> dict[str, int]:
        """Return how many claims have each verdict."""
        return {v: sum(found.verdict == v for found in self.judgements) for v in VERDICTS}


@dataclass(frozen=True, eq=False)
class Content:
    """The whole report.

    Parameters
    ----------
    cases : the cases that the answers come from
    wanted : the case that answers would come from, for a run without it
    costs : of the estimators in those cases
    optima : IPOPT beside `mhe`, a row per case and sensors
    apart : matrices of the pen that cannot spin
    belief : what it costs to believe that of one that does, a sentence each
    made_with : label and text
    """

    answers: Sequence[Answer]
    cases: Sequence[str]
    wanted: str
    costs: Sequence[Cost]
    optima: Sequence[Optimum]
    apart: Sequence[Matrix]
    belief: Sequence[str]
    parts: Sequence[ReportPart]
    made_with: Sequence[tuple[str, str]]
    run: Mapping[str, Any]

    @property
    def judgements(self) -> list[Judgement]:
        """All claims of all suites."""
        return [found for part in self.parts for found in part.judgements]

    def counts(self) -> dict[str, int]:
        """Return how many claims have each verdict."""
        return {v: sum(part.counts()[v] for part in self.parts) for v in VERDICTS}


def content(results: Results, suites: Sequence[Suite], run: Mapping[str, Any]) -> Content:
    """Gather what the report says of a run.

    Parameters
    ----------
    results : tables of the run
    suites : that it shows, in this order
    run : content of ``run.json``
    """
    own, table = own_selections(results.rows), configurations_of(run)
    found = matrices(results.rows, (*MATRIX, *own), table)
    cases = list(dict.fromkeys(matrix.case for matrix in found))
    first = MATRIX[0]
    return Content(
        [Answer(matrix, advice(matrix)) for matrix in found],
        cases,
        f"suite {first.suite}, case “{first.case}”",
        costs(found),
        optima(results.rows),
        matrices(results.rows, NO_SPIN),
        costs_of_belief(results.rows),
        [_part(suite, results.of(suite.name), run) for suite in suites],
        made_with(run),
        run,
    )


def slug(text: str) -> str:
    """Return a text that can be part of an address: small letters, digits, hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def _part(suite: Suite, results: Results, run: Mapping[str, Any]) -> ReportPart:
    rows = results.rows
    return ReportPart(
        suite.name,
        f"suite-{slug(suite.name)}",
        suite.title,
        " ".join(suite.summary.split()),
        _missing(suite, results, run),
        _command(suite, results, run),
        len(rows.drop_duplicates(list(TASK_COLUMNS))),
        list(suite.figures(results)) if len(rows) else [],
        list(suite.tables(results)) if len(rows) else [],
        judge(load_claims(suite.claims) if suite.claims else (), rows),
        [] if suite.is_timed else _comparisons(rows),  # times are no errors
        broken_off(rows),
        criteria_written(suite.claims) if suite.claims else {},
    )


NO_UNIT = "1"
"""Of ratios and of what is counted: operations are no error."""


def _comparisons(rows: pd.DataFrame) -> list[Comparison]:
    errors = rows[rows["unit"] != NO_UNIT]
    found = [_comparison(row) for row in paired(errors, SIMPLE, CONVERGED).to_dict("records")]
    order = in_order((row.sensors for row in found), CONFIGURATIONS)
    return sorted(found, key=lambda row: order.index(row.sensors))


def _comparison(row: Mapping[Hashable, Any]) -> Comparison:
    return Comparison(
        str(row["sensors"]),
        str(row["quantity"]),
        str(row["unit"]),
        float(row[SIMPLE]),
        float(row[CONVERGED]),
        float(row["difference"]),
        float(row["low"]),
        float(row["high"]),
        int(row["pairs"]),
        str(row["verdict"]),
    )


def _missing(suite: Suite, results: Results, run: Mapping[str, Any]) -> str:
    data = run.get("data")
    if len(results.rows):
        return ""
    said = suite.missing(Scope(data=str(data) if data else None))
    return said or f"This run has no results of the suite {suite.name}."


def _command(suite: Suite, results: Results, run: Mapping[str, Any]) -> str:
    if again := run.get("again"):
        return str(again)
    words = ["pen-mhe", "benchmark", suite.name]
    if isinstance(run.get("seeds"), int):
        words += ["--seeds", str(run["seeds"])]
    elif len(results.rows):
        words += ["--seeds", str(int(np.max(results.rows["seed"])) + 1)]
    for field in ("estimators", "cases"):
        if asked := run.get(field):
            words += [f"--{field}", ",".join(map(str, asked))]
    if len(results.rows):
        suite_name, case, sensors, estimator, seed = results.rows[list(TASK_COLUMNS)].iloc[0]
        if suite.reads(Task(suite_name, case, sensors, estimator, int(seed))):
            words += ["--data", "DIR"]
    return " ".join(words)
