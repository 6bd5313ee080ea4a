"""The site: every page is reached, every link leads somewhere, nothing comes from afar."""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import pen_mhe as pm
from suites.table import ASKED_FOR, NAMED
from tests.pages import BLOCK, PAGES, ROOT, SITE, blocks

DOCS = ROOT / "docs"
INDEX = DOCS / "index.md"
NOTEBOOKS = tuple(sorted((ROOT / "notebooks").glob("*.ipynb")))
LINK = re.compile(r"\]\(([^)\s]+)\)")
PICTURE = re.compile(r"!\[.*?\]\(([^)\s]+)\)")
ALL_OF_README = 120


def in_navigation(page: Path) -> Iterator[Path]:
    """Yield what a page's tables of contents name, and what these name, as files."""
    for block in blocks(page):
        if block.language == "{toctree}":
            for line in block.text.splitlines():
                if line and not line.startswith(":"):
                    stem = (page.parent / line).resolve()
                    for kind in (".md", ".ipynb"):
                        found = stem.with_name(stem.name + kind)
                        if found.is_file():
                            yield found
                            if kind == ".md":
                                yield from in_navigation(found)


def text_of(page: Path) -> str:
    """Return the sentences of a page, without its code."""
    if page.suffix == ".ipynb":
        cells = json.loads(page.read_text("utf-8"))["cells"]
        text = "\n\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
    else:
        text = page.read_text("utf-8")
    return BLOCK.sub("", text)


def anchors(page: Path) -> set[str]:
    """Return what a link to a part of a page may name: its headings, in GitHub's way and ours."""
    headings = re.findall(r"^#+ (.+)$", text_of(page), re.MULTILINE)
    plain = (re.sub(r"[^\w\s-]", "", heading.lower()) for heading in headings)
    return {words.replace(" ", "-") for words in plain}


@pytest.mark.parametrize("page", [*PAGES, *NOTEBOOKS], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(text_of(page)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, part = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name}: {link}"
        assert target.is_relative_to(ROOT), f"{page.name}: {link}"
        if part:
            assert part in anchors(target), f"{page.name}: {link} names no heading"


def test_every_page_and_notebook_is_in_the_navigation() -> None:
    reached = [*in_navigation(INDEX)]
    pages = {page for page in PAGES if page.is_relative_to(DOCS)} - {INDEX}
    missing = (pages | set(NOTEBOOKS)) - set(reached)
    assert not missing, f"in no table of contents, see docs/index.md: {sorted(map(str, missing))}"
    assert len(reached) == len(set(reached)), "a page stands twice in the navigation"


def test_notebooks_begin_with_first_light() -> None:
    order = [page.stem for page in in_navigation(INDEX) if page.suffix == ".ipynb"]
    assert order == sorted(order, key=lambda name: (name != "first_light", name))


@pytest.mark.parametrize("name", [*NAMED, *ASKED_FOR])
def test_every_suite_has_a_page(name: str) -> None:
    page = DOCS / "suites" / f"{name}.md"
    assert page.is_file(), f"docs/suites/{name}.md is missing"
    shown = [block.words for block in blocks(page) if block.language == "{suite}"]
    assert shown == [{name}]
    assert f"]({name}.md)" in (DOCS / "suites" / "index.md").read_text("utf-8")


def test_the_api_page_has_every_name_of_the_door_once() -> None:
    text = (DOCS / "api.md").read_text("utf-8")
    named = re.findall(r"^\.\. auto(?:class|function|data|exception):: pen_mhe\.(\w+)$", text, re.M)
    assert len(named) == len(set(named))
    assert set(named) == {*pm.__all__, "__version__"}


def test_the_readme_is_one_page() -> None:
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= ALL_OF_README


def test_pictures_are_shown() -> None:
    """No picture that nobody sees, and none that is missing."""
    text = "\n".join(text_of(page) for page in PAGES)
    shown = {posixpath.basename(link) for link in PICTURE.findall(text)}
    assert shown == {path.name for path in DOCS.glob("*.png")}


def test_every_picture_has_a_command() -> None:
    told = (DOCS / "rooms.md").read_text("utf-8").partition("## Pictures of these pages")[2]
    first_cells = " ".join(re.findall(r"^\| (`.+?) \|", told, re.MULTILINE))
    assert set(re.findall(r"`([^`\s]+\.png)`", first_cells)) == {p.name for p in DOCS.glob("*.png")}


def test_the_site_is_no_page() -> None:
    assert not any(page.is_relative_to(SITE) for page in PAGES)
