"""Only the last folder of a path is made, and `results` with a folder in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from estimation.output_folder import RESULTS, check_folder, make_folder
from models.errors import InputError
from tests.rooms_to_write import as_nobody, contents


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("folder", [Path("new"), RESULTS, RESULTS / "new", Path(".")])
def test_it_is_made(folder: Path, here: Path) -> None:
    check_folder(folder)
    assert contents(here) == {}
    make_folder(folder)
    make_folder(folder)
    assert folder.is_dir()


@pytest.mark.parametrize("do", [check_folder, make_folder])
@pytest.mark.parametrize(
    ("folder", "reason"),
    [
        ("typo/new", "there is no folder typo to make it in"),
        ("results/typo/new", "there is no folder results/typo to make it in"),
        ("file", "(Not a directory|File exists)"),
        ("file/new", "Not a directory"),
        ("n" * 256, "File name too long"),
    ],
)
def test_it_is_refused(folder: str, reason: str, do: Callable[[Path], None], here: Path) -> None:
    (here / "file").touch()
    with pytest.raises(InputError, match=f"output {folder}: {reason}, expected a folder that can"):
        do(Path(folder))
    assert contents(here) == {"file": b""}


def test_one_that_is_only_read(here: Path) -> None:
    with as_nobody(), pytest.raises(InputError, match=r"Permission denied|there is no folder"):
        check_folder(here / "new")
    assert contents(here) == {}
