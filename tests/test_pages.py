"""Every block of README and docs runs, or says why not; every command that they name exists."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import typer

from commands.cli import app
from models.pen_file import load_pen
from tests import pages
from tests.pages import INLINE, PAGES, ROOT, WORDS, Block, blocks, inline_commands, of_language

LANGUAGES = {"python", "sh", "toml", "text"}
DIRECTIVE = "{"
"""A fence whose language begins so is one of the site's."""

ELSEWHERE = frozenset(WORDS) - {"slow", "data", "pen"}
"""Words of blocks that no test runs."""

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))

SHORTER = {
    "benchmark speed --seeds 200": "benchmark speed --seeds 4 --cases turntable_20",
    "suites.speed.export ": "suites.speed.export --problems turntable_20 --windows 4 -- ",
    "benchmark pen --pen MINE.toml": "benchmark pen --pen MINE.toml --seeds 1 --estimators ekf",
    "benchmark pen tilt": "benchmark tilt",
    "--seeds 20": "--seeds 1",
}
"""What is long on a page → the same, shorter."""

RUN_ELSEWHERE = {
    path: test
    for test, names in {
        "tests/test_docs.py": ("own_models.md",),
        "tests/models/test_constraints_page.py": ("constraints.md",),
        "tests/pen_mhe/test_outliers_page.py": ("outliers.md",),
        "tests/estimation/test_inputs.py": ("inputs.md",),
        "tests/estimation/test_causality.py": ("late_readings.md",),
    }.items()
    for path in (ROOT / "docs" / name for name in names)
}
"""Page → the test that runs its Python and looks at what comes out."""


MISSING: Any = typer.BadParameter.__subclasses__()[0]
"""Typer has no name for it outside."""


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def with_blocks(language: str) -> list[Path]:
    return [page for page in PAGES if of_language(page, language)]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_blocks_say_what_they_are(page: Path) -> None:
    """Also of words that nobody knows, and of commands that hide in plain text."""
    for block in blocks(page):
        if block.language.startswith(DIRECTIVE):
            continue
        assert block.language in LANGUAGES, f"{block}: language {block.language!r}"
        assert block.words <= set(WORDS), f"{block}: {sorted(block.words - set(WORDS))}"
        if block.language != "sh":
            assert not re.search(r"^\s*(pen-mhe|pip) ", block.text, re.MULTILINE), block
    assert len(re.findall("^```", page.read_text("utf-8"), re.MULTILINE)) % 2 == 0
    assert not re.search(r"^ {4}(pen-mhe|pip|make) ", page.read_text("utf-8"), re.MULTILINE)


@pytest.mark.parametrize(
    "page", [page for page in with_blocks("python") if page not in RUN_ELSEWHERE], ids=name_of
)
def test_python_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    pages.run_python(page, without=ELSEWHERE | {"slow", "data"})


@pytest.mark.parametrize("page", RUN_ELSEWHERE, ids=name_of)
def test_python_that_runs_elsewhere_does(page: Path) -> None:
    text = (ROOT / RUN_ELSEWHERE[page]).read_text("utf-8")
    assert "run_python(" in text
    assert page.name in text


@pytest.mark.parametrize("page", with_blocks("toml"), ids=name_of)
def test_toml_is_read(page: Path, tmp_path: Path) -> None:
    for block in of_language(page, "toml"):
        tomllib.loads(block.text)
        if "pen" in block.words:
            (tmp_path / "mine.toml").write_text(block.text, "utf-8")
            load_pen(tmp_path / "mine.toml")


def parse(words: list[str], *, whole: bool = True) -> None:
    """Find the command that words name, and read its options; nothing runs.

    Parameters
    ----------
    whole : nothing may be missing; a sentence may name a command without its recording
    """
    command: Any = typer.main.get_command(app)
    context = command.make_context("pen-mhe", [], resilient_parsing=True)
    if words[0] in {"--help", *(name for known in command.params for name in known.opts)}:
        return
    while hasattr(command, "commands"):
        context.resilient_parsing = False
        name, command, words = command.resolve_command(context, words)
        if hasattr(command, "commands"):
            context = command.make_context(name, [], parent=context, resilient_parsing=True)
    with contextlib.nullcontext() if whole else contextlib.suppress(MISSING):
        command.make_context("", list(words), parent=context.parent)


def test_a_page_tells_of_every_word() -> None:
    text = (ROOT / "docs" / "rooms.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \|$", text, re.MULTILINE)
    assert [word for word, _ in rows] == list(WORDS)
    assert {word for word, says in rows if "not run" in says or "a test" in says} == ELSEWHERE


def written(page: Path) -> list[tuple[str, str, bool]]:
    """Return (where, command, whether whole) of all commands of `pen-mhe` on a page."""
    if page.suffix == ".ipynb":
        cells = json.loads(page.read_text("utf-8"))["cells"]
        text = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
        whole = re.findall(r"^(?: {4})?(pen-mhe .+)$", text.replace("\\\n", " "), re.MULTILINE)
        found = [(page.name, line, True) for line in whole]
        return found + [(page.name, line, False) for line in INLINE.findall(text)]
    found = [
        (str(block), line, True)
        for block in of_language(page, "sh")
        for line in pages.commands(block)
        if line.startswith("pen-mhe ")
    ]
    return found + [(name_of(page), line, False) for line in inline_commands(page)]


@pytest.mark.parametrize(
    "page", [page for page in (*PAGES, *NOTEBOOKS) if written(page)], ids=name_of
)
def test_commands_and_their_options_exist(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PEN_MHE_DATA", str(ROOT))
    for where, line, whole in written(page):
        try:
            parse(shlex.split(line, comments=True)[1:], whole=whole)
        except Exception as error:
            pytest.fail(f"{where}: `{line}`: {error or type(error).__name__}")


def test_a_command_that_does_not_exist_is_seen() -> None:
    for words in (
        ["estimat"],
        ["estimate", "pen.csv", "--no-such-option"],
        ["estimate", "--pen", "reference"],
        ["calibrate", "stil"],
    ):
        with pytest.raises(Exception, match=r"did you mean|No such|unknown|[Mm]issing"):
            parse(words)


def rules() -> set[str]:
    return set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_make_has_the_rules_that_pages_name(page: Path) -> None:
    text = page.read_text("utf-8")
    named = re.findall(r"`make ([a-z-]+)", text) + re.findall(r"^make ([a-z-]+)", text, re.M)
    assert set(named) <= rules()


@pytest.fixture
def on_path(tmp_path: Path) -> dict[str, str]:
    """The environment of a reader who has installed `pen-mhe`."""
    folder = tmp_path / "bin"
    folder.mkdir()
    program = "from commands.cli import app; app()"
    for name, words in (("pen-mhe", f"-c '{program}'"), ("python", "")):
        shim = folder / name
        shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n', "utf-8")
        shim.chmod(0o755)
    return {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}",
    }


def shorter(text: str) -> str:
    for long, short in SHORTER.items():
        text = text.replace(long, short)
    return text


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [p for p in PAGES if any(not block.words & ELSEWHERE for block in of_language(p, "sh"))],
    ids=name_of,
)
def test_commands_run(
    page: Path, tmp_path: Path, on_path: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder of the page's own; what needs recordings runs where there are some.

    The page's Python goes first: it may write a file that a command reads.
    """
    left_out = ELSEWHERE | (set() if os.environ.get("PEN_MHE_DATA") else {"data"})
    folder = tmp_path / "page"
    folder.mkdir()

    def run(what: str, text: str) -> None:
        done = subprocess.run(
            ["bash", "-euc", shorter(text)],
            cwd=folder, env=on_path, capture_output=True, text=True, timeout=1200, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{what}: {done.stdout[-500:]}{done.stderr[-1500:]}"

    monkeypatch.chdir(folder)
    pages.run_python(page, without=left_out)
    run(f"{name_of(page)}, before", pages.before(page))
    for block in of_language(page, "sh"):
        if not block.words & left_out:
            run(str(block), block.text)


def test_blocks_are_found() -> None:
    """The reading of pages itself: fences, words, lines, comments."""
    start = ROOT / "docs" / "start.md"
    assert {block.language for block in blocks(start)} >= {"python", "sh"}
    first: Block = blocks(start)[0]
    assert start.read_text("utf-8").splitlines()[first.line - 1] == first.text.splitlines()[0]
    assert any(inline_commands(page) for page in PAGES)
