"""Fixtures shared by all rooms."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import estimation.native
from estimation.native import compiler
from tests.cover import left_out

QUICK_CC = str(Path(__file__).with_name("quick_cc"))


def pytest_configure(config: pytest.Config) -> None:
    """Without slow tests, compile in a third of the time, here and in every process started here.

    What is compiled says the same to the last bit, later. A ``CC`` of one's own is kept.
    """
    if config.option.markexpr == "not slow" and shutil.which("gcc"):
        os.environ.setdefault("CC", QUICK_CC)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Without slow tests, take of tests marked ``cover`` the cases of their cover only."""
    if config.option.markexpr == "not slow" and (out := left_out(items)):
        config.hook.pytest_deselected(items=out)
        gone = set(out)
        items[:] = [item for item in items if item not in gone]


@pytest.fixture
def optimised(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Compile as the product does: for tests of what the compiler makes, and for long runs."""
    with monkeypatch.context() as patch:
        if os.environ.get("CC") == QUICK_CC:
            patch.delenv("CC")
        compiler.cache_clear()
        yield
    compiler.cache_clear()


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of real recordings, from PEN_MHE_DATA; skips where it is absent."""
    folder = os.environ.get("PEN_MHE_DATA")
    if not folder:
        pytest.skip("PEN_MHE_DATA is not set: no real recordings here")
    if not Path(folder).is_dir():
        pytest.skip(f"PEN_MHE_DATA={folder} is not a folder: no real recordings here")
    return Path(folder)


@pytest.fixture(scope="session")
def dpoint_folder(data_folder: Path) -> Path:
    """The D-POINT recording."""
    folder = data_folder / "dpoint_pen"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent")
    return folder


@pytest.fixture
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do not compile: for tests that build many models and take few steps."""
    monkeypatch.setattr(estimation.native, "compiler", lambda: None)
