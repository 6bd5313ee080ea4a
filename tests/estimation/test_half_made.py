"""What is half made is claimed, however soon another run takes it for left over."""

from __future__ import annotations

from pathlib import Path

import pytest

from estimation.half_made import half_made_folder


def test_a_folder_that_is_taken_for_left_over_before_it_is_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another run looks between its making and its lock, and removes it: it is made again."""
    original, made = Path.mkdir, list[Path]()

    def mkdir(self: Path, mode: int = 0o777) -> None:
        original(self, mode)
        made.append(self)
        if len(made) == 1:
            self.rmdir()

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with half_made_folder(tmp_path / "library.so") as folder:
        assert folder.is_dir()
        assert folder == made[1]
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_a_folder_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), half_made_folder(tmp_path / "missing" / "library.so"):
        pass
