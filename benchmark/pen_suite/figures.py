from __future__ import annotations
from collections.abc import Sequence
from benchmark.figures.figure import Figure
from benchmark.tasks.results import Results


def figures(results: Results) -> Sequence[Figure]:
    return []
