"""Blocks of code of README and docs, as readers find them.

A block runs as it stands, one after the other down its page, in a folder of its own. The word
after its language says where it does not run with the others; `WORDS` has all of them. A comment
``<!-- before … -->`` holds commands that make the files which a reader has.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "docs" / "site"
"""What builds the site of the docs: no page of it."""

PAGES = (
    ROOT / "README.md",
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if SITE not in path.parents),
)
WORDS: Mapping[str, str] = MappingProxyType(
    {
        "slow": "runs in make test-all only",
        "data": "needs real recordings, in the folder that PEN_MHE_DATA names",
        "network": "installs something",
        "cluster": "needs several machines",
        "board": "needs a microcontroller",
        "checkout": "runs in the checkout, as make does",
        "pen": "a whole pen file",
    }
)
"""Word after a block's language → what it says."""

BLOCK = re.compile(r"^```(\S*)([^\n]*)\n(.*?)^```[ ]*$", re.MULTILINE | re.DOTALL)
BEFORE = re.compile(r"^<!-- before\n(.*?)^-->$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"(?<!`)`(pen-mhe [^`…]+)`(?!`)")


@dataclass(frozen=True)
class Block:
    """A block of a page.

    Parameters
    ----------
    page : the file
    line : that its text begins on
    language : as after its fence: `python`, `sh`, `toml`, …
    words : of `WORDS`
    text : what it holds
    """

    page: Path
    line: int
    language: str
    words: frozenset[str]
    text: str

    def __str__(self) -> str:
        """Where it stands."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"


@cache
def blocks(page: Path) -> tuple[Block, ...]:
    """Return the blocks of a page, from its top to its bottom."""
    text = page.read_text("utf-8")
    return tuple(
        Block(page, text.count("\n", 0, m.start(3)) + 1, m[1], frozenset(m[2].split()), m[3])
        for m in BLOCK.finditer(text)
    )


def of_language(page: Path, language: str) -> tuple[Block, ...]:
    return tuple(block for block in blocks(page) if block.language == language)


def before(page: Path) -> str:
    """Return the commands that make the files which a reader of the page has."""
    return "".join(BEFORE.findall(page.read_text("utf-8")))


def commands(block: Block) -> list[str]:
    """Return the commands of a shell's block, a line each."""
    return [line for line in block.text.replace("\\\n", " ").splitlines() if line.strip()]


def inline_commands(page: Path) -> list[str]:
    """Return the commands of `pen-mhe` within sentences, but for those with a gap in them."""
    text = BLOCK.sub("", page.read_text("utf-8"))
    return [" ".join(found.split()) for found in INLINE.findall(text)]


def run_python(page: Path, *, without: frozenset[str] = frozenset()) -> dict[str, Any]:
    """Run the Python of a page in the folder that one is in; return the names it defines.

    Parameters
    ----------
    without : words whose blocks are left out
    """
    names: dict[str, Any] = {"__name__": page.stem}
    for block in of_language(page, "python"):
        if not block.words & without:
            source = "\n" * (block.line - 1) + block.text
            exec(compile(source, str(page), "exec"), names)
    return names
