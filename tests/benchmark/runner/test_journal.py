"""The journal: what is written comes back exactly, whatever a kill leaves of the last line."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from benchmark.runner.outcome_lines import NAME, outcome_journal
from benchmark.tasks.task import OK, Outcome, Quantity, Series, Task, failed
from models.errors import InputError
from tests.benchmark.runner.workload import tasks

TASK, OTHER = tasks(2)
texts = st.text(st.characters(exclude_categories=["Cs"]))
floats = st.floats(allow_nan=True, allow_infinity=True)
numbers = st.floats(width=64)
quantities = st.builds(
    Quantity, texts, texts, floats, floats, floats, st.booleans(), st.none() | floats
)


def columns(n: int) -> st.SearchStrategy[Series]:
    """Series of n instants."""
    column = arrays("<f8", n, elements=numbers)
    return st.builds(Series, texts, texts, column, column, st.none() | column, st.none() | column)


series = st.integers(0, 4).flatmap(columns)
outcomes = st.builds(
    Outcome,
    texts,
    st.lists(quantities, max_size=3).map(tuple),
    st.integers(0, 10**9),
    floats,
    floats,
    floats,
    texts,
    texts,
    st.lists(series, max_size=2).map(tuple),
)
named = st.builds(Task, texts, texts, texts, texts, st.integers(0, 10**6))


def bits(value: Any) -> Any:
    """An outcome as values that are equal where every bit is."""
    if isinstance(value, float):
        return "NaN" if value != value else struct.pack("<d", value)
    if isinstance(value, np.ndarray):
        return (value.shape, value.dtype.str, value.tobytes())
    if dataclasses.is_dataclass(value):
        return [bits(getattr(value, f.name)) for f in dataclasses.fields(value)]
    return [bits(v) for v in value] if isinstance(value, tuple) else (type(value), value)


def found(*figures: float) -> Outcome:
    return Outcome("m", tuple(Quantity.single("a", "s", f) for f in figures), 1, 1.0, 0.0, 0.0)


@settings(max_examples=60, deadline=None)
@given(task=named, identity=texts, outcome=outcomes, other=outcomes)
def test_outcomes_survive_exactly(
    task: Task, identity: str, outcome: Outcome, other: Outcome
) -> None:
    with TemporaryDirectory() as folder:
        with outcome_journal(Path(folder)) as journal:
            journal.append(task, identity, outcome)
            journal.append(task, identity + "!", other)
            assert bits(journal.read(task, identity)) == bits(outcome)
        with outcome_journal(Path(folder)) as journal:
            for made_with, expected in ((identity, outcome), (identity + "!", other)):
                if expected.status != "failed":
                    assert journal.has(task, made_with)
                    assert bits(journal.read(task, made_with)) == bits(expected)


def test_other_code_has_not_run_the_task(tmp_path: Path) -> None:
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, "code", found(1.0))
        assert journal.path.read_bytes().endswith(b"}\n")  # at once: a kill would not lose it
        assert journal.has(TASK, "code")
        assert not journal.has(TASK, "other code")
        assert not journal.has(OTHER, "code")
        with pytest.raises(KeyError):
            journal.read(OTHER, "code")


def test_a_failed_task_is_read_now_and_tried_again_by_the_next_run(tmp_path: Path) -> None:
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, "code", failed("it broke"))
        assert journal.read(TASK, "code").reason == "it broke"
    with outcome_journal(tmp_path) as journal:
        assert not journal.has(TASK, "code")
        journal.append(TASK, "code", found(2.0))
    with outcome_journal(tmp_path) as journal:
        assert journal.read(TASK, "code").quantities == found(2.0).quantities


def test_what_was_found_last_counts(tmp_path: Path) -> None:
    with outcome_journal(tmp_path) as journal:
        for figure in (1.0, 2.0):
            journal.append(TASK, "code", found(figure))
            assert journal.read(TASK, "code").quantities == found(figure).quantities
    with outcome_journal(tmp_path) as journal:
        assert journal.read(TASK, "code").quantities == found(2.0).quantities


def test_what_is_added_together_is_there_as_a_whole(tmp_path: Path) -> None:
    both = [(TASK, "code", found(1.0)), (OTHER, "code", found(2.0))]
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, "code", found(0.0))
        journal.append_together(both)
        for task, identity, outcome in both:
            assert journal.read(task, identity).quantities == outcome.quantities
    with outcome_journal(tmp_path) as journal:
        for task, identity, outcome in both:
            assert journal.read(task, identity).quantities == outcome.quantities


def test_wherever_a_kill_cuts_the_last_line_the_others_stay(tmp_path: Path) -> None:
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, "code", found(1.0))
        first = journal.path.stat().st_size
        journal.append(OTHER, "code", dataclasses.replace(found(2.0), reason="≤ 横折竖 😀"))
    whole = (tmp_path / NAME).read_bytes()
    for end in range(first, len(whole)):
        (tmp_path / NAME).write_bytes(whole[:end])
        with outcome_journal(tmp_path) as journal:
            assert journal.has(TASK, "code")
            assert not journal.has(OTHER, "code")
            assert journal.path.stat().st_size == first
    with outcome_journal(tmp_path) as journal:
        journal.append(OTHER, "code", found(3.0))
    with outcome_journal(tmp_path) as journal:
        assert journal.read(TASK, "code").quantities == found(1.0).quantities
        assert journal.read(OTHER, "code").quantities == found(3.0).quantities


@pytest.mark.parametrize(
    "garbage",
    [b"\n", b"{}\n", b"[1]\n", b"\xff\xfe\n", b'{"identity": "a", "status": "ok", "task": {}}\n'],
)
def test_garbage_is_refused_with_its_place(tmp_path: Path, garbage: bytes) -> None:
    with outcome_journal(tmp_path) as journal:
        journal.append(TASK, "code", found(1.0))
    before = (tmp_path / NAME).read_bytes()
    with_garbage = before + garbage + before
    (tmp_path / NAME).write_bytes(with_garbage)
    for _ in range(2):  # the first refusal holds no lock
        with pytest.raises(InputError) as refused, outcome_journal(tmp_path):
            pytest.fail("it was opened")
        assert str(refused.value) == (
            f"journal {tmp_path / NAME}: the line at byte {len(before)} is none of a journal, "
            "expected a file that only this command writes"
        )
    assert (tmp_path / NAME).read_bytes() == with_garbage


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    with outcome_journal(tmp_path / "new") as journal:
        journal.append(TASK, "code", found(1.0))
        with pytest.raises(InputError, match=r"new is being written by another run, expected one"):
            outcome_journal(tmp_path / "new").__enter__()
        assert journal.has(TASK, "code")
    with outcome_journal(tmp_path / "new") as journal:
        assert journal.has(TASK, "code")
        assert journal.read(TASK, "code").status == OK
