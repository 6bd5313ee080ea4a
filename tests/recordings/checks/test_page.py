"""The page on checks names every check of the table, asks what it asks, and its example runs."""

from __future__ import annotations

import re
from pathlib import Path

from recordings.checks.mountings import RESTS
from recordings.checks.table import CHECKS

PAGE = (Path(__file__).parents[3] / "docs" / "check.md").read_text("utf-8")


def test_the_table_is_that_of_the_code() -> None:
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+\?) \| ([^|]+) \|$", PAGE, re.MULTILINE)
    assert [(name, asks) for name, asks, _ in rows] == [(one.name, one.asks) for one in CHECKS]
    needs_pen = {name for name, _, tells in rows if "needs `--pen`" in tells}
    assert needs_pen == {one.name for one in CHECKS if one.of_pen}


def test_the_example_runs() -> None:
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert code is not None
    exec(compile(code[1], "check.md", "exec"), {})


def test_figures_of_the_text_are_those_of_the_code() -> None:
    assert f"explains {RESTS:.0%}".replace("%", " %") in PAGE


def test_what_makes_a_check_meaningless_is_asked_before_it() -> None:
    names = [one.name for one in CHECKS]
    for at, one in enumerate(CHECKS):
        assert set(one.unless) <= set(names[:at])
