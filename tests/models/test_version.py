"""Which version wrote a file: it is said in the file, and a later one's is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow.parquet
import pytest

from models.bundled import bundled_pens
from models.errors import InputError
from models.pen_file import load_pen, parse_pen
from models.turntable import load_turntable
from models.version import check_version, version
from recordings.formats.tables import write_table

PEN: dict[str, Any] = {"name": "p", "sensors": {"a": {"preset": "ADXL202"}}}


@pytest.mark.parametrize(
    ("written", "running"),
    [("0.2", "0.2.0"), ("0.2.7", "0.2.0"), ("0.1", "0.2.0"), ("0.9", "1.0"), ("1.7", "1.2.3")],
)
def test_what_the_same_or_an_earlier_series_has_written_is_read(written: str, running: str) -> None:
    check_version(written, "pen", running=running)


@pytest.mark.parametrize(
    ("written", "running"),
    [("0.3", "0.2.0"), ("1.0", "0.2.0"), ("0.10", "0.9.1"), ("2.0", "1.9")],
)
def test_what_a_later_series_has_written_is_refused(written: str, running: str) -> None:
    with pytest.raises(InputError) as refused:
        check_version(written, "pen", running=running)
    assert str(refused.value) == (
        f"pen: written by pen-mhe {written}, expected a version that pen-mhe {running} knows: "
        "its own series or an earlier one"
    )


def test_a_pen_file_may_say_with_which_version_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    text = bundled_pens()["reference"].read_text("utf-8")
    path.write_text(f'pen_mhe_version = "{version()}"\n{text}', "utf-8")
    assert load_pen(path) == load_pen(bundled_pens()["reference"])
    path.write_text(f'pen_mhe_version = "99.0"\nkey_of_another_day = 1\n{text}', "utf-8")
    with pytest.raises(InputError, match=r"mine\.toml: key pen_mhe_version: written by pen-mhe 99"):
        load_pen(path)


@pytest.mark.parametrize("written", [0.2, "new", "", "1", "0.2.0.0", ["0.2"]])
def test_a_version_is_a_text_with_dots(written: object) -> None:
    with pytest.raises(InputError, match=r"key pen_mhe_version: .* is no version, expected e.g. "):
        parse_pen({**PEN, "pen_mhe_version": written})


def test_a_turntable_may_say_it_too(tmp_path: Path) -> None:
    path = tmp_path / "table.toml"
    path.write_text('pen_mhe_version = "99.0"\n', "utf-8")
    with pytest.raises(InputError, match=r"table\.toml: key pen_mhe_version: written by"):
        load_turntable(path)


def test_a_parquet_table_says_with_which_version_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    table = pd.DataFrame({"time_s": [0.0, 1.0], "status": ["solved", "solved"]})
    write_table(table, path)
    assert pyarrow.parquet.read_schema(path).metadata[b"pen_mhe_version"] == version().encode()
    pd.testing.assert_frame_equal(pd.read_parquet(path), table)
