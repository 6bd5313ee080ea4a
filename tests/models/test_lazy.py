"""A face of a toy room."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

STUB = """\
from toy_room import bench as bench
from toy_room.hammer import Hammer as Hammer
from toy_room.hammer import _weight as _weight
"""
ROOM = """\
from models.lazy import lazy_face

__getattr__, __dir__, __all__ = lazy_face(__name__, __file__)
"""


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "toy_room"
    folder.mkdir()
    (folder / "__init__.pyi").write_text(STUB)
    (folder / "__init__.py").write_text(ROOM)
    (folder / "hammer.py").write_text("class Hammer: pass\n_weight = 2\n")
    (folder / "bench.py").write_text("")
    (folder / "saw.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield folder
    for name in [name for name in sys.modules if name.split(".")[0] == "toy_room"]:
        del sys.modules[name]


def test_a_name_is_imported_when_asked_for_and_stays(room: Path) -> None:
    import toy_room

    assert toy_room.__all__ == ["Hammer", "bench"]
    assert {"Hammer", "bench", "_weight"} <= set(dir(toy_room))
    assert "toy_room.hammer" not in sys.modules
    hammer = toy_room.Hammer
    assert hammer is sys.modules["toy_room.hammer"].Hammer
    assert vars(toy_room)["Hammer"] is hammer
    assert toy_room._weight == 2


def test_a_module_may_be_on_a_face(room: Path) -> None:
    from toy_room import bench

    assert bench is sys.modules["toy_room.bench"]


def test_what_is_not_on_it_is_found_as_ever(room: Path) -> None:
    import toy_room
    from toy_room import saw

    assert saw is sys.modules["toy_room.saw"]
    with pytest.raises(AttributeError, match="module 'toy_room' has no attribute 'Hamer'") as error:
        toy_room.Hamer  # noqa: B018
    assert (error.value.name, error.value.obj) == ("Hamer", toy_room)
    with pytest.raises(ImportError, match="cannot import name 'Hamer'"):
        from toy_room import Hamer  # noqa: F401


def test_star_takes_the_public_names(room: Path) -> None:
    names: dict[str, object] = {}
    exec("from toy_room import *", names)
    assert {"Hammer", "bench"} <= set(names)
    assert "_weight" not in names
