"""A bar where somebody looks: on a terminal, in a notebook, and nowhere else."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import pytest

from estimation import progress
from estimation.progress_bar import EVERY_S


class Shown:
    """What a notebook has shown, in the place of IPython's display."""

    def __init__(self) -> None:
        self.bars: list[str] = []

    def display(self, bar: dict[str, str], *, raw: bool, display_id: bool) -> Shown:
        assert raw
        assert display_id
        self.bars.append(bar["text/plain"])
        return self

    def update(self, bar: dict[str, str], *, raw: bool) -> None:
        assert raw
        self.bars.append(bar["text/plain"])


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> Shown:
    """A kernel without IPython: what the progress bar asks it for."""
    shown, module = Shown(), ModuleType("IPython.display")
    vars(module)["display"] = shown.display
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    return shown


def test_a_notebook_shows_a_bar_to_its_end(
    notebook: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 0.1 * EVERY_S, 1.5 * EVERY_S, 1.6 * EVERY_S])
    monkeypatch.setattr("estimation.progress_bar.time.monotonic", lambda: next(clock))
    with progress("runs") as start:
        advance = start(5)
        for steps in (1, 2, 2):
            advance(steps)
    assert notebook.bars == ["runs: 0 of 5", "runs: 3 of 5", "runs: 5 of 5"]


def test_a_pipe_is_told_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with progress("runs") as start:
        start(5)(5)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_how_many(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes it for a terminal
    monkeypatch.setenv("COLUMNS", "100")
    with progress("runs") as start:
        start(5)(5)
    told: Any = capsys.readouterr()
    assert told.out == ""
    assert "runs" in told.err
    assert "5/5" in told.err
