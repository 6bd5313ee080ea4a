"""The old file or the new one, whatever happens, and nothing beside it."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import stat
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from estimation import half_made, output_file
from estimation.output_file import check_file, whole_file, whole_files, write_whole
from models.errors import InputError
from tests.rooms_to_write import as_nobody, contents, room_for

OLD, NEW = b"old " * 1000, b"new " * 2000


class Broken(BaseException):
    """As an interrupt: no error."""


@pytest.fixture(params=["old", "none"])
def before(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, bytes]:
    """What lies in the folder before: an old file, or nothing."""
    if request.param == "old":
        (tmp_path / "o.csv").write_bytes(OLD)
    return contents(tmp_path)


def test_a_whole_file_takes_the_old_ones_place(tmp_path: Path, before: dict[str, bytes]) -> None:
    with whole_file(tmp_path / "o.csv") as file:
        file.write(NEW)
        file.flush()
        assert contents(tmp_path).items() >= before.items()
    assert contents(tmp_path) == {"o.csv": NEW}


@pytest.mark.parametrize("error", [Broken(), KeyboardInterrupt(), ValueError("broken")])
def test_an_exception_in_the_middle(
    error: BaseException, tmp_path: Path, before: dict[str, bytes]
) -> None:
    def write() -> None:
        with whole_file(tmp_path / "o.csv") as file:
            file.write(NEW)
            file.flush()
            raise error

    with pytest.raises(type(error)):
        write()
    assert contents(tmp_path) == before


def test_a_limit_in_the_middle(tmp_path: Path, before: dict[str, bytes]) -> None:
    where = f"output {tmp_path / 'o.csv'}: File too large, expected a file that can be written"
    with room_for(len(NEW) - 1), pytest.raises(InputError) as raised:
        write_whole(tmp_path / "o.csv", NEW)
    assert str(raised.value) == where
    assert contents(tmp_path) == before


@pytest.mark.parametrize("call", ["open", "fsync", "replace"])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EDQUOT])
def test_any_error_of_the_system_is_a_sentence(
    call: str,
    number: int,
    tmp_path: Path,
    before: dict[str, bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object, **__: object) -> int:
        raise OSError(number, os.strerror(number), "elsewhere")

    with monkeypatch.context() as patch:
        patch.setattr(os, call, refuse)
        with pytest.raises(InputError, match=f"output .*o.csv: {os.strerror(number)}, expected"):
            write_whole(tmp_path / "o.csv", NEW)
    assert contents(tmp_path) == before


def test_several_files_are_all_written_before_one_is_put_in_place(tmp_path: Path) -> None:
    paths = [tmp_path / "a", tmp_path / "b"]
    paths[0].write_bytes(OLD)

    def write() -> None:
        with whole_files(paths) as (first, second):
            first.write(b"short")
            second.write(NEW)

    with room_for(len(OLD)), pytest.raises(InputError, match=f"output {tmp_path}: File too large"):
        write()
    assert contents(tmp_path) == {"a": OLD}


def test_a_link_is_followed_and_stays(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    target, link = tmp_path / "deep" / "o.csv", tmp_path / "link.csv"
    link.symlink_to(target)
    for content in (OLD, NEW):  # the first time its file is missing
        write_whole(link, content)
        assert link.is_symlink()
        assert contents(tmp_path / "deep") == {"o.csv": content}


def test_the_mode_of_an_old_file_stays_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    old, new, plain = tmp_path / "old", tmp_path / "new", tmp_path / "plain"
    old.write_bytes(OLD)
    old.chmod(0o604)
    for path in (old, new):
        write_whole(path, NEW)
    plain.touch()
    assert stat.S_IMODE(old.stat().st_mode) == 0o604
    assert new.stat().st_mode == plain.stat().st_mode


REFUSED: dict[str, tuple[str, str]] = {
    "folder": ("folder", "Is a directory"),
    "no folder": ("typo/o.csv", "there is no folder .*typo"),
    "file as folder": ("file/o.csv", "Not a directory"),
    "long": ("n" * 256, "File name too long"),
    "circle": ("circle", "Too many levels of symbolic links"),
}


@pytest.mark.parametrize("write", [check_file, lambda path: write_whole(path, NEW)])
@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_written_is_refused(
    case: str, write: Callable[[Path], Any], tmp_path: Path
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_bytes(OLD)
    (tmp_path / "circle").symlink_to("circle")
    names = set(os.listdir(tmp_path))
    name, reason = REFUSED[case]
    with pytest.raises(InputError, match=f"output .*: {reason}, expected a file that can be"):
        write(tmp_path / name)
    assert set(os.listdir(tmp_path)) == names
    assert (tmp_path / "file").read_bytes() == OLD


def test_the_longest_name_can_be_written(tmp_path: Path) -> None:
    name = "ä" * 127 + "n"
    write_whole(tmp_path / name, NEW)
    assert contents(tmp_path) == {name: NEW}


def test_a_check_makes_nothing(tmp_path: Path, before: dict[str, bytes]) -> None:
    check_file(tmp_path / "o.csv")
    assert contents(tmp_path) == before


@pytest.mark.parametrize("write", [check_file, lambda path: write_whole(path, NEW)])
def test_folders_and_files_that_are_only_read(write: Callable[[Path], Any]) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        locked, file = folder / "locked", folder / "locked" / "o.csv"
        locked.mkdir()
        file.write_bytes(OLD)
        file.chmod(0o666)
        folder.chmod(0o755)
        for mode, path in ((0o555, file), (0o555, locked / "new.csv")):
            locked.chmod(mode)
            with as_nobody(), pytest.raises(InputError, match="Permission denied, expected"):
                write(path)
        locked.chmod(0o777)
        file.chmod(0o444)  # its folder would let it be replaced
        with as_nobody(), pytest.raises(InputError, match=r"o\.csv: Permission denied, exp"):
            write(file)
        assert contents(folder) == {"locked": b"no file", "locked/o.csv": OLD}


def test_a_device_is_written_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "full.csv").symlink_to("/dev/full")
    check_file(tmp_path / "full.csv")
    with pytest.raises(InputError, match=r"full\.csv: No space left on device, expected a file"):
        write_whole(tmp_path / "full.csv", NEW)
    write_whole("/dev/null", NEW)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_a_fifo_is_written_as_it_is(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "o.csv")
    check_file(tmp_path / "o.csv")
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append((tmp_path / "o.csv").read_bytes()))
    reader.start()
    write_whole(tmp_path / "o.csv", NEW)
    reader.join()
    assert read == [NEW]
    assert stat.S_ISFIFO((tmp_path / "o.csv").stat().st_mode)


def test_what_is_printed_to_stays_the_same_file(tmp_path: Path) -> None:
    code = "from estimation.output_file import write_whole as w; w('/dev/stdout', b'x'); print(1)"
    with open(tmp_path / "o", "ab") as printed:
        subprocess.run([sys.executable, "-c", code], stdout=printed, check=True)
    assert (tmp_path / "o").read_bytes() in (b"x1\n", b"1\n")
    assert set(os.listdir(tmp_path)) == {"o"}


def test_what_a_killed_run_left_goes_and_what_another_works_on_stays(tmp_path: Path) -> None:
    dead, live = tmp_path / ".o.csv.0123abcd.part", tmp_path / ".o.csv.89ef0123.part"
    others = [".p.csv.0123abcd.part", "o.csv.0123abcd.part", ".o.csv.part", ".o.csv.mine.part"]
    for path in (dead, live, *(tmp_path / name for name in others)):
        path.write_bytes(OLD)
    with live.open("rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        write_whole(tmp_path / "o.csv", NEW)
        assert set(os.listdir(tmp_path)) == {live.name, "o.csv", *others}
    check_file(tmp_path / "o.csv")
    assert set(os.listdir(tmp_path)) == {"o.csv", *others}


def test_one_that_was_taken_for_left_over_is_begun_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between making it and locking it another run may remove it."""
    taken: list[Path] = []
    real = fcntl.flock

    def flock(held: int, how: int) -> None:
        if not taken:
            taken.extend(tmp_path.glob(".o.csv.*.part"))
            taken[0].unlink()
        real(held, how)

    monkeypatch.setattr(fcntl, "flock", flock)
    write_whole(tmp_path / "o.csv", NEW)
    assert len(taken) == 1
    assert contents(tmp_path) == {"o.csv": NEW}


def test_without_locks_nothing_is_left_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(half_made, "_locks", None)
    monkeypatch.setattr(output_file, "HAS_LOCKS", False)
    (tmp_path / ".o.csv.0123abcd.part").write_bytes(OLD)
    write_whole(tmp_path / "o.csv", NEW)
    assert contents(tmp_path) == {"o.csv": NEW, ".o.csv.0123abcd.part": OLD}


def test_sigkill_while_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "o.csv").write_bytes(OLD)
    code = (
        "import sys\nfrom estimation.output_file import whole_file\n"
        "with whole_file(sys.argv[1]) as file:\n"
        "    file.write(b'new')\n    file.flush()\n    print('half', flush=True)\n"
        "    sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "o.csv")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"half\n"
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert (tmp_path / "o.csv").read_bytes() == OLD
    assert len(os.listdir(tmp_path)) == 2
    write_whole(tmp_path / "o.csv", NEW)
    assert contents(tmp_path) == {"o.csv": NEW}
