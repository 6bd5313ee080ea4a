"""The site: every page is reached, every link leads somewhere, nothing comes from afar."""

from __future__ import annotations

import json
import posixpath
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import pen_mhe as pm
from suites.studies import STUDIES
from suites.table import ASKED_FOR, MODULES
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


@pytest.mark.parametrize("name", [*MODULES, *ASKED_FOR, *STUDIES])
def test_every_suite_and_study_has_a_page(name: str) -> None:
    page = DOCS / "suites" / f"{name}.md"
    assert page.is_file(), f"docs/suites/{name}.md is missing"
    shown = [block.words for block in blocks(page) if block.language == "{suite}"]
    assert shown == ([{name}] if name not in STUDIES else [])
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


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` does."""
    pytest.importorskip("sphinx", reason="the extra [docs] is not installed")
    pytest.importorskip("furo", reason="the extra [docs] is not installed")
    rule = re.search(
        r"-m sphinx (.+?)\. build/docs$",
        (ROOT / "Makefile").read_text("utf-8"),
        re.MULTILINE | re.DOTALL,
    )
    assert rule
    folder = tmp_path_factory.mktemp("site")
    words = rule[1].replace("\\\n", " ").replace("build/doctrees", str(folder / "trees")).split()
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words, ".", str(folder / "site")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert not done.stderr
    return folder / "site"


@pytest.mark.slow
def test_the_site_comes_from_here_alone(built: Path) -> None:
    """No font, script, style or picture from another machine: links go there, nothing else."""
    pages = list(built.rglob("*.html"))
    assert len(pages) > len(PAGES)
    for page in pages:
        text = page.read_text("utf-8")
        assert not re.search(r"<(?:script|img|iframe|source)[^>]*src=\"(?:https?:)?//", text), page
        for tag in re.findall(r"<link [^>]*>", text):
            assert not re.search(r"href=\"(?:https?:)?//", tag), f"{page}: {tag}"
    for style in built.rglob("*.css"):
        assert not re.search(r"url\(['\"]?https?:|@import", style.read_text("utf-8")), style


@pytest.mark.slow
def test_the_site_begins_and_its_suites_are_told(built: Path) -> None:
    assert 'url=docs/index.html"' in (built / "index.html").read_text("utf-8")
    pen = (built / "docs" / "suites" / "pen.html").read_text("utf-8")
    assert "pen-1-accurate" in pen
    assert "free pen, handwriting" in pen
    api = (built / "docs" / "api.html").read_text("utf-8")
    assert all(f'id="pen_mhe.{name}"' in api for name in pm.__all__)


def test_the_site_is_no_page() -> None:
    assert not any(page.is_relative_to(SITE) for page in PAGES)
