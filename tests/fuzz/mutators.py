"""Changes that know what they change: cells, headers, lines of TOML, members of an archive.

Bytes changed by chance are refused at the first line; these come further.
"""

from __future__ import annotations

import io
import random
import zipfile
from collections.abc import Callable, Mapping
from types import MappingProxyType

from recordings.foreign.column_names import KIND_WORDS
from recordings.foreign.header_units import KNOWN_UNITS
from tests.fuzz.words import NUMBERS, STAMPS, TOKENS

ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "cp1252", "gb18030", "cp932")
DELIMITERS = (",", ";", "\t", "|", " ", ", ")
CHATTER = (
    "# restarted",
    "// Update Rate: 100.0Hz",
    "",
    "---;---",
    "sep=;",
    "g,g,g,deg/s",
    '"',
    "}",
)
VALUES = ("[]", "{}", "[[1]]", "true", '"g"', '"a b"', "[0, 0, 0]", "{ x = 1 }")
_KINDS = tuple(word for words in KIND_WORDS.values() for word in words)
Draw = random.Random


def mutated(data: bytes, draw: Draw) -> bytes:
    """Return bytes of which some are changed: by what they are, or by chance."""
    for _ in range(draw.choice((1, 1, 2, 4))):
        if draw.random() < 0.3:
            data = _bytes(data, draw)
        elif data[:2] == b"PK":
            data = _members(data, draw)
        else:
            data = _text(data, draw)
    return data


def _bytes(data: bytes, draw: Draw) -> bytes:
    """Cut out, double, or replace a part by a token or by chance."""
    start = draw.randint(0, len(data))
    end = min(len(data), start + draw.choice((0, 1, 1, 4, 30)))
    put = draw.choice((b"", data[start:end] * 2, *draw.choices(TOKENS, k=2), b"7"))
    return data[:start] + put + data[end:]


def _members(data: bytes, draw: Draw) -> bytes:
    """Change a member of an archive, its name, or how often it is there."""
    packed = io.BytesIO()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(packed, "w") as new:
            members = [(one.filename, old.read(one)) for one in old.infolist()]
            k = draw.randrange(len(members))
            name, content = members[k]
            change = draw.random()
            if change < 0.1:
                members.pop(k)
            elif change < 0.2:
                members.append((draw.choice(("../x.csv", "a/b/Metadata.csv", "x.json")), content))
            else:
                members[k] = (name, mutated(content, draw))
            for name, content in members:
                new.writestr(name, content)
    except Exception:  # it is damaged already
        return _bytes(data, draw)
    return packed.getvalue()


def _text(data: bytes, draw: Draw) -> bytes:
    """Change lines or cells of a text."""
    text = data.decode("utf-8", "replace")
    lines = text.split("\n")
    if draw.random() < 0.3:
        change = draw.choice(tuple(_OF_LINES.values()))
        lines = change(lines, draw)
    else:
        k = 0 if draw.random() < 0.3 else draw.randrange(len(lines))
        lines[k] = _line(lines[k], draw, is_header=k == 0)
    encoding = "utf-8" if draw.random() < 0.95 else draw.choice(ENCODINGS)
    return "\n".join(lines).encode(encoding, "replace")


def _line(line: str, draw: Draw, *, is_header: bool) -> str:
    if "=" in line and not is_header:  # of TOML
        key, _, value = line.partition("=")
        if draw.random() < 0.3:
            return f"{draw.choice((key.strip() + '_deg', 'kind', 'x.y', _word(draw)))} = {value}"
        return f"{key}= {draw.choice((*VALUES, *NUMBERS, value.strip()))}"
    delimiter = max(DELIMITERS[:5], key=line.count)
    cells = line.split(delimiter)
    k = draw.randrange(len(cells))
    change = draw.random()
    if change < 0.1:
        cells.pop(k)
    elif change < 0.2:
        cells.insert(k, cells[k])
    elif change < 0.3:
        other = draw.randrange(len(cells))
        cells[k], cells[other] = cells[other], cells[k]
    elif is_header:
        cells[k] = draw.choice((_word(draw), cells[k] + _word(draw), "", f"{cells[k]} [mGa]"))
    else:
        cells[k] = draw.choice(
            (*draw.choices(NUMBERS, k=4), *draw.choices(STAMPS, k=2), cells[k] * 2)
        )
    return delimiter.join(cells)


def _word(draw: Draw) -> str:
    """Return something that a header may say."""
    unit = draw.choice(("", *KNOWN_UNITS, "d/s", "m/(s^2)", "°/s"))
    stem = draw.choice((*_KINDS, "time", "ts", "frame", "加速度", "roll rate", "[recording]"))
    brackets = draw.choice(("{} {} ({})", "{}_{}_{}", "{}{}[{}]", "{}.{}", "{}{}"))
    return brackets.format(stem, draw.choice("xyzw1230"), unit)


_OF_LINES: Mapping[str, Callable[[list[str], Draw], list[str]]] = MappingProxyType(
    {
        "without one": lambda lines, draw: _at(lines, draw, 0),
        "one twice": lambda lines, draw: _at(lines, draw, 2),
        "one often": lambda lines, draw: _at(lines, draw, draw.choice((20, 300))),
        "chatter": lambda lines, draw: [
            *lines[: (k := draw.randint(0, len(lines)))], draw.choice(CHATTER), *lines[k:]
        ],
        "shuffled": lambda lines, draw: [lines[0], *draw.sample(lines[1:], len(lines) - 1)],
        "other delimiters": lambda lines, draw: "\n".join(lines).replace(
            max(DELIMITERS[:4], key="\n".join(lines).count), draw.choice(DELIMITERS)
        ).split("\n"),
        "decimal commas": lambda lines, _: [line.replace(".", ",") for line in lines],
        "of a monitor": lambda lines, _: [f"12:00:0{k % 9}.25 -> {x}" for k, x in enumerate(lines)],
        "in quotes": lambda lines, _: [
            ",".join(f'"{cell}"' for cell in line.split(",")) for line in lines
        ],
        "with keys": lambda lines, _: [
            " ".join(map(": ".join, zip(lines[0].split(","), line.split(","), strict=False)))
            for line in lines
        ],
    }
)  # fmt: skip
"""What is done to all lines."""


def _at(lines: list[str], draw: Draw, times: int) -> list[str]:
    k = draw.randrange(len(lines))
    return [*lines[:k], *[lines[k]] * times, *lines[k + 1 :]]
