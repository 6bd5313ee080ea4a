"""Files as they are before they were packed or written in another encoding: in UTF-8, bounded."""

from __future__ import annotations

import codecs
import gzip
import tempfile
import zlib
from contextlib import ExitStack
from pathlib import Path
from typing import BinaryIO, cast

from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular
from recordings.foreign.header_units import ELSEWHERE

GZIP, UTF8_MARK = b"\x1f\x8b", codecs.BOM_UTF8
MARKS = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
LATIN = "cp1252"
"""What a text is that is no UTF-8: a superset of Latin-1 where that has no letters."""
OF_EAST_ASIA = ("gb18030", "cp932", "cp949")
"""What else it may be: where its beginning then holds a word of `ELSEWHERE`."""
IN_MEMORY = 1 << 24
PIECE = 1 << 20


def open_text(path: Path, where: str, expected: str) -> tuple[BinaryIO, str]:
    """Open a text, packed by gzip or not, as bytes of UTF-8 without a mark.

    Returns
    -------
    The open file at its beginning, and the encoding that it had

    Raises
    ------
    InputError
        If it cannot be opened, is damaged, or is larger than `models.limits.LIMITS` allows.
    """
    with ExitStack() as opened:
        file = opened.enter_context(open_regular(path, where, expected, "table_bytes"))
        if file.read(2) == GZIP:
            file.seek(0)
            file = opened.enter_context(_gunzipped(file, where))
        file.seek(0)
        encoding = encoding_of(file)
        if encoding != "utf-8":
            file.seek(0)
            file = opened.enter_context(_in_utf8(file, encoding, where))
        file.seek(0)
        if file.read(3) != UTF8_MARK:
            file.seek(0)
        opened.pop_all()
    return file, encoding


def encoding_of(file: BinaryIO) -> str:
    """Return the encoding of a text: by its mark, by UTF-16's zero bytes, else UTF-8 or Latin."""
    start = file.read(PIECE)
    for mark, encoding in MARKS:
        if start.startswith(mark):
            return encoding
    sample = start[: 1 << 12]
    for offset, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(sample) > 8 and sample[offset::2].count(0) > 0.4 * len(sample):
            return encoding
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        while start:
            decoder.decode(start)
            start = file.read(PIECE)
    except UnicodeDecodeError:
        return next((one for one in OF_EAST_ASIA if _has_words(sample, one)), LATIN)
    return "utf-8"


def _has_words(sample: bytes, encoding: str) -> bool:
    text = sample.decode(encoding, "replace")
    return any(word in text for word in ELSEWHERE)


def _gunzipped(file: BinaryIO, where: str) -> BinaryIO:
    found = spooled()
    try:
        with gzip.GzipFile(fileobj=file) as packed:
            while piece := packed.read(PIECE):
                found.write(piece)
                check_most("unpacked_bytes", found.tell(), where)
    except InputError:
        found.close()
        raise
    except (OSError, EOFError, zlib.error) as error:
        found.close()
        raise InputError(f"{where}: cannot be unpacked, expected a whole gzip file") from error
    return found


def _in_utf8(file: BinaryIO, encoding: str, where: str) -> BinaryIO:
    decoder = codecs.getincrementaldecoder(encoding)("replace")
    found = spooled()
    while piece := file.read(PIECE):
        found.write(decoder.decode(piece).encode("utf-8", "replace"))
        if found.tell() > IN_MEMORY:
            check_most("unpacked_bytes", found.tell(), where)
    found.write(decoder.decode(b"", True).encode("utf-8", "replace"))
    return found


def spooled() -> BinaryIO:
    """Return a file without a name, in memory while it is small."""
    return cast(BinaryIO, tempfile.SpooledTemporaryFile(max_size=IN_MEMORY))
