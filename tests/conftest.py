"""Fixtures shared by all rooms."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import estimation.native


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
