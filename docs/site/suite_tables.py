"""The directive ``suite``: what a suite asks, runs and is judged by, from its own tables."""

import os
from collections import defaultdict
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from benchmark.tasks.suite import Scope, Suite
from benchmark.verdicts.claims import Claim, load_claims
from models import InputError
from suites.table import ASKED_FOR, find_suite

OWN_PEN = "reference"
"""The pen that a suite about a pen of one's own is shown with."""
FEW = 6
"""So many names are listed; more are counted."""
HEADS = {
    "cases": ("case", "sensors", "estimators", "seeds of `--seeds 5`"),
    "claims": ("claim", "who says it", "what", "criterion"),
}


def row(*cells: str) -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def table(kind: str, rows: list[str]) -> list[str]:
    """Return a table of one of `HEADS`."""
    head = HEADS[kind]
    return [row(*head), row(*("---" for _ in head)), *rows, ""]


def listed(names: set[str]) -> str:
    """Return names as code, or their number where they are many."""
    if len(names) > FEW:
        return f"{len(names)} of them"
    return ", ".join(f"`{name}`" for name in sorted(names) if name)


def case_rows(suite: Suite, scope: Scope) -> list[str]:
    """Return a row of each case: what it is run with."""
    found: dict[str, list[Any]] = defaultdict(list)
    for task in suite.tasks(scope):
        found[task.case].append(task)
    return [
        row(
            case,
            listed({task.sensors for task in tasks}),
            listed({task.estimator for task in tasks}),
            str(len({task.seed for task in tasks})),
        )
        for case, tasks in found.items()
    ]


def claim_row(claim: Claim) -> str:
    """Return the row of a claim: who says what, and by which criterion it is judged."""
    criterion = claim.criterion
    if claim.not_judged:
        criterion += f". Not judged: {claim.not_judged}"
    for change in claim.changed:
        criterion += f". Changed on {change.on}: {change.why}"
    return row(f"`{claim.id}`", claim.source, claim.says, criterion)


def page_of(name: str) -> list[str]:
    """Return what the tables of a suite say, as Markdown."""
    suite, data = find_suite(name), os.environ.get("PEN_MHE_DATA")
    scope = Scope(data=data, pen=OWN_PEN if name in ASKED_FOR else None)
    asked = "pen --pen MINE.toml" if name in ASKED_FOR else name
    needs = " --data DATA" if suite.missing(Scope()) else ""
    lines = [f"**{suite.title}.** {suite.summary}", ""]
    lines += ["```sh", f"pen-mhe benchmark {asked}{needs} --output results", "```", ""]
    cases = case_rows(suite, scope)
    lines += [suite.missing(scope), "", "**Cases.**", "", *table("cases", cases)] if cases else []
    if suite.claims:
        claims = load_claims(suite.claims)
        lines += ["**Claims**, committed before the first run; the report has each with its "]
        lines += ["figure, its interval and the commit of its criterion.", ""]
        lines += table("claims", [claim_row(claim) for claim in claims])
    return lines


class SuiteTables(SphinxDirective):
    """What stands in the tables of a suite."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the page's part."""
        try:
            lines = page_of(self.arguments[0])
        except InputError as error:
            raise self.error(str(error)) from error
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app: Any) -> dict[str, bool]:
    """Make the directive known."""
    app.add_directive("suite", SuiteTables)
    return {"parallel_read_safe": True}
