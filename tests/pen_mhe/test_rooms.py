"""Rooms are found: in a checkout by their files, installed by what the distribution lists."""

from __future__ import annotations

from importlib.metadata import PackagePath
from pathlib import Path

import pytest

from models.errors import InputError
from pen_mhe import rooms as module
from pen_mhe.rooms import MARKS, ROOT, rooms

KNOWN = {
    *("models", "estimation", "ekf_baseline", "classical_baseline", "mhe", "recordings"),
    *("codegen", "pen_mhe", "benchmark", "suites", "commands"),
}


@pytest.fixture(autouse=True)
def forgotten() -> None:
    rooms.cache_clear()


def test_the_rooms_of_this_checkout() -> None:
    found = rooms()
    assert set(found) >= KNOWN
    assert list(found) == sorted(found)
    assert not {"tests", "notebooks", "docs"} & set(found)
    assert all((ROOT / room / mark).is_file() for room in found for mark in MARKS)


def test_a_room_is_typed_and_a_package(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").touch()
    for name, marks in (("whole", MARKS), ("no package", MARKS[1:]), ("not typed", MARKS[:1])):
        (tmp_path / name).mkdir()
        for mark in marks:
            (tmp_path / name / mark).touch()
    assert rooms(tmp_path) == ("whole",)


def test_installed_only_what_the_distribution_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stranger").mkdir()
    for mark in MARKS:
        (tmp_path / "stranger" / mark).touch()
    listed = ["models/py.typed", "mhe/py.typed", "mhe/config.py", "mhe/below/py.typed", "a.pth"]
    monkeypatch.setattr(module, "files", lambda _: [PackagePath(name) for name in listed])
    assert rooms(tmp_path) == ("mhe", "models")


@pytest.mark.parametrize("listed", [None, []])
def test_neither_checkout_nor_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: list[PackagePath] | None
) -> None:
    monkeypatch.setattr(module, "files", lambda _: listed)
    with pytest.raises(InputError, match="is no checkout, and no installed pen-mhe lists"):
        rooms(tmp_path)
