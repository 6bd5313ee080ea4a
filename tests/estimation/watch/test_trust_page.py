"""The page on trust says of each word what the code says, and names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

from estimation.status import SENTENCES, Status
from estimation.watch.flags import Flag

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "trust.md").read_text("utf-8")


def test_the_page_has_every_word_as_the_code_has_it() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (yes|no) \| (.*) \|$", PAGE, re.MULTILINE)
    assert rows == [
        (status.label, "yes" if status.is_solved else "no", SENTENCES[status])
        for status in (Status.SOLVED, *Status)
    ]


def test_the_page_has_every_flag() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (\d+) \| .* \|$", PAGE, re.MULTILINE)
    assert [(word, int(bit)) for word, bit in rows] == [(flag.word, flag.value) for flag in Flag]


def test_every_test_that_the_page_names_exists() -> None:
    named = re.findall(r"\btests/[\w/]+(?:\.py)?", PAGE)
    assert len(named) > 10
    missing = [path for path in named if not (ROOT / path).exists()]
    assert not missing
    commands = re.findall(r"`make (\w+)", PAGE)
    rules = (ROOT / "Makefile").read_text("utf-8")
    assert all(re.search(rf"^{command}:", rules, re.MULTILINE) for command in commands)
