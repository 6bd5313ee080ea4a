"""What `make sanitize` runs finds what it is for; the rest of it is too long for every day."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.engines import needs_compiler
from tests.sanitize.exports import EXPORTS, QUICK, Watched, export_of, run

FAULTS = {
    "i < m->n_y; i++) clean[i]": ("i <= m->n_y; i++) clean[i]", "stack-buffer-overflow"),
    "(real)status;": ("(real)(status + 2147483647 + status);", "signed integer overflow"),
}
"""C as it is → what a slip makes of it, and what a sanitiser calls that."""
FIRST, *REST = FAULTS
SHORT = Watched("ekf", EXPORTS["window"].stream, steps=100)


@pytest.mark.slow
@needs_compiler
def test_a_filter_does_what_c_allows(tmp_path: Path) -> None:
    told = run(SHORT, export_of(SHORT), tmp_path)
    assert told.returncode == 0, told.stderr
    assert int(told.stdout.split()[0]) > 1000


@needs_compiler
@pytest.mark.parametrize("right", [FIRST, *(pytest.param(x, marks=pytest.mark.slow) for x in REST)])
def test_a_slip_is_found(right: str, tmp_path: Path) -> None:
    export = export_of(SHORT)
    wrong, called = FAULTS[right]
    assert right in export.source
    slipped = replace(export, source=export.source.replace(right, wrong))
    told = run(SHORT, slipped, tmp_path)
    assert told.returncode != 0
    assert called in told.stderr


def test_ci_takes_some_of_all() -> None:
    assert set(QUICK) < set(EXPORTS)
    assert {EXPORTS[name].estimator for name in QUICK} == {"ekf", "mhe-rti"}
