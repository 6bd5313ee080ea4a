"""The report as text for terminals: Markdown without figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from benchmark.report.broken import MOST, Broken
from benchmark.report.content import PAPERS_WORLD, SYMBOLS, TITLE, Content, ReportPart
from benchmark.report.in_short import IN_SHORT, headlines, in_short
from benchmark.report.matrix import SHOWN, Cell, Matrix
from benchmark.report.numbers import count, interval, number, seconds
from benchmark.report.optimal import ABOUT_OPTIMUM, HEAD, OPTIMUM
from benchmark.report.sentences import (
    PAIR_SYMBOLS,
    answer_is_about,
    lead,
    notes,
    papers_world,
    refuted,
    verdict_sentence,
)
from benchmark.verdicts.judge import VERDICTS
from models.escaped import code_span, in_markdown


def terminal(content: Content) -> str:
    """Return the Markdown."""
    blocks = [f"# {TITLE}", in_markdown(lead(content)), "## The answer", *answer_blocks(content)]
    blocks += [*_papers_world(content), "## Verdicts", verdict_sentence(content), _counts(content)]
    if found := refuted(content):
        blocks += ["Claims that do not hold:", _list(_claim(part, j.claim.id) for part, j in found)]
    for part in content.parts:
        blocks += _part(part)
    blocks.append("## Made with")
    blocks.append(_list(f"{label}: {text}" for label, text in content.made_with) or "Unknown.")
    return "\n\n".join(block for block in blocks if block) + "\n"


def answer_blocks(content: Content) -> list[str]:
    """Return the matrices with their advice, and what the estimators cost."""
    if not content.answers:
        return [in_markdown(f"This run has no results of {content.wanted}.")]
    blocks = [
        *map(in_markdown, headlines(content.answers)),
        table(IN_SHORT, in_short(content.answers)),
        f"{in_markdown(answer_is_about(content))} RMSE: median over the seeds (smallest to "
        "largest); `*` marks the best.",
    ]
    for answer in content.answers:
        matrix = answer.matrix
        blocks.append(in_markdown(f"### {matrix.quantity}, {matrix.unit} ({matrix.case})"))
        blocks.append(in_markdown(answer.advice.more))
        blocks.append(matrix_table(matrix))
    blocks.append("### What the estimators cost")
    rows = [
        (
            cost.estimator,
            seconds(cost.median_s),
            seconds(cost.p99_s),
            f"{number(100 * cost.solved)} %",
            cost.runs,
            cost.broken,
        )
        for cost in content.costs
    ]
    head = ("Estimator", "Step, median", "Step, p99", "Steps solved", "Runs", "Broken off")
    blocks.append(table(head, rows))
    return [*blocks, *_optima(content)]


def _optima(content: Content) -> list[str]:
    """Return IPOPT beside `mhe`."""
    if not content.optima:
        return []
    rows = [
        (
            row.case,
            row.sensors,
            row.runs,
            row.steps,
            seconds(row.near_s),
            seconds(row.reference_s),
            number(row.distance),
            number(row.largest),
            f"{number(100 * row.solved)} %",
        )
        for row in content.optima
    ]
    return [f"### {OPTIMUM}", in_markdown(ABOUT_OPTIMUM), table(HEAD, rows)]


def _papers_world(content: Content) -> list[str]:
    """Return the matrices of the pen that cannot spin."""
    if not content.apart and not content.belief:
        return []
    blocks = [f"## {PAPERS_WORLD}", in_markdown(papers_world(content)), _list(content.belief)]
    for matrix in content.apart:
        blocks.append(in_markdown(f"### {matrix.quantity}, {matrix.unit} ({matrix.case})"))
        blocks.append(matrix_table(matrix))
    return blocks


def matrix_table(matrix: Matrix) -> str:
    """Return one matrix as a table."""
    rows = [
        (name, *map(_cell, row)) for name, row in zip(matrix.sensors, matrix.cells, strict=True)
    ]
    return table(("Sensors", *matrix.estimators), rows)


def table(head: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table with columns of even width; pipes in cells are escaped."""
    cells = [[in_markdown(str(cell)) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(head))]
    lines = ["| " + " | ".join(map(str.ljust, row, widths)) + " |" for row in cells]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])


def _part(part: ReportPart) -> list[str]:
    blocks = [f"## {in_markdown(part.title)}", in_markdown(part.summary), in_markdown(part.missing)]
    if part.judgements:
        rows = [
            (
                f"{SYMBOLS[found.verdict]} {found.verdict}",
                found.claim.says,
                found.claim.source,
                ". ".join([found.claim.criterion, *notes(found.claim, part.written)]),
                _with_interval(found.figure, found.low, found.high),
                found.holding,
                found.pairs,
            )
            for found in part.judgements
        ]
        head = ("Verdict", "Claim", "Source", "Criterion", "Figure (95 %)", "Parts", "Runs")
        blocks += ["### Claims", table(head, rows)]
    if part.comparisons:
        pairs = [
            (
                row.sensors,
                f"{row.quantity}, {row.unit}" if row.unit else row.quantity,
                number(row.simple),
                number(row.optimising),
                number(row.difference),
                interval(row.low, row.high) or "no spread",
                row.pairs,
                f"{PAIR_SYMBOLS[row.verdict]} {row.verdict}",
            )
            for row in part.comparisons
        ]
        names = ("Sensors", "Quantity", "EKF", "MHE", "MHE minus EKF", "95 % interval", "Runs")
        blocks += ["### EKF against MHE", table((*names, "The MHE is"), pairs)]
    for title, caption, heads, shown in part.tables:
        blocks += [in_markdown(f"### {title}"), in_markdown(caption), table(heads, shown)]
    if part.broken:
        lines = [
            (row.case, row.sensors, row.estimator, *_outcome(row)) for row in part.broken[:MOST]
        ]
        columns = ("Case", "Sensors", "Estimator", "Seeds", "Status", "Reason")
        tasks = sum(len(row.seeds) for row in part.broken)
        blocks += [
            "### Tasks without a full result",
            f"{tasks} of {count(part.tasks, 'task')}.",
            table(columns, lines),
        ]
        if len(part.broken) > MOST:
            blocks.append(f"{len(part.broken) - MOST} more lines are in results.parquet.")
    return [*blocks, f"Make it again: {code_span(part.command)}"]


def _outcome(row: Broken) -> tuple[str, str, str]:
    return ", ".join(map(str, row.seeds)), row.status, row.reason or "no reason given"


def _counts(content: Content) -> str:
    rows = [(part.title, *(part.counts()[word] for word in VERDICTS)) for part in content.parts]
    rows.append(("All", *(content.counts()[word] for word in VERDICTS)))
    return table(("Suite", *(f"{SYMBOLS[word]} {word}" for word in VERDICTS)), rows)


def _claim(part: ReportPart, claim_id: str) -> str:
    claim = next(found.claim for found in part.judgements if found.claim.id == claim_id)
    return f"{claim.says} ({claim.source})"


def _cell(cell: Cell) -> str:
    if cell.state != SHOWN:
        return cell.state
    seeds = f", {cell.seeds} of {cell.of}" if cell.seeds < cell.of else ""
    best = " *" if cell.best else ""
    return _with_interval(cell.median, cell.low, cell.high) + seeds + best


def _with_interval(figure: float, low: float, high: float) -> str:
    ends = interval(low, high)
    return f"{number(figure)} ({ends})" if ends else number(figure)


def _list(entries: Iterable[str]) -> str:
    return "\n".join(f"- {in_markdown(entry)}" for entry in entries)
