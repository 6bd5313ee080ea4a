"""Limits of readers: the table is the page, the environment sets others, nothing is waited for."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from models.errors import InputError
from models.limits import LIMITS, check_most, most, variable
from models.pen_file import load_pen
from models.regular_files import open_regular, read_text

PAGE = Path(__file__).resolve().parents[2] / "docs" / "limits.md"


def test_the_page_has_every_limit() -> None:
    rows = re.findall(r"^\| ([\d ]+) \| (.*) \| `(\w+)` \|$", PAGE.read_text(), re.MULTILINE)
    listed = {name: (int(number.replace(" ", "")), of) for number, of, name in rows}
    assert listed == {variable(name): (row.default, row.of) for name, row in LIMITS.items()}


def test_the_environment_sets_another_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    check_most("columns", 2000, "f")
    with pytest.raises(InputError, match="f: 2001 columns of a table, expected at most 2000"):
        check_most("columns", 2001, "f")
    monkeypatch.setenv("PEN_MHE_MOST_COLUMNS", "3000")
    check_most("columns", 2001, "f")
    for bad in ("0", "-1", "1e3", "", "a\nb", "9" * 40):
        monkeypatch.setenv("PEN_MHE_MOST_COLUMNS", bad)
        with pytest.raises(InputError, match=r"PEN_MHE_MOST_COLUMNS is .* positive whole number"):
            most("columns")


@pytest.mark.parametrize("special", ["/dev/zero", "/proc/self", "fifo"])
def test_nothing_is_waited_for(tmp_path: Path, special: str) -> None:
    path = tmp_path / special if special == "fifo" else Path(special)
    if special == "fifo":
        os.mkfifo(path)
    with pytest.raises(InputError, match=r"Is a directory|is a device, a pipe or a socket"):
        load_pen(path)


def test_a_large_file_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pen.toml").write_text("# " + "x" * 200_000)
    with pytest.raises(InputError, match="200002 bytes of a TOML file, expected at most 200000"):
        load_pen(tmp_path / "pen.toml")
    monkeypatch.setenv("PEN_MHE_MOST_TOML_BYTES", "300000")
    with pytest.raises(InputError, match="key name: is missing"):
        load_pen(tmp_path / "pen.toml")


def test_a_file_of_the_systems_own_says_zero_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/proc/cpuinfo").is_file():
        pytest.skip("no /proc here")
    monkeypatch.setenv("PEN_MHE_MOST_TOML_BYTES", "10")
    with pytest.raises(InputError, match="bytes of a TOML file, expected at most 10"):
        read_text(Path("/proc/cpuinfo"), "cpuinfo", "text", "toml_bytes")


def test_a_file_that_is_refused_is_closed(tmp_path: Path) -> None:
    before = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").is_dir() else None
    for _ in range(3):
        with pytest.raises(InputError):
            open_regular(tmp_path, "f", "a file", "toml_bytes")
    if before is not None:
        assert len(os.listdir("/proc/self/fd")) == before
