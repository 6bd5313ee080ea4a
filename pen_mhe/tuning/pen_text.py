"""Numbers of a pen file replaced in its text: comments, order and units stay as they are."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from models.bundled import bundled_pens
from models.errors import InputError
from models.motion import OLD_KEY
from models.parsed import toml_data
from models.pen_config import PenConfig
from models.pen_file import AnyPen, parse_pen, presets
from models.plain_names import plain_name
from models.regular_files import read_text
from models.units import accepted_names, split_unit
from pen_mhe.tuning.parameters import MOTION, Parameter, rounded

DIGITS, DIGITS_OF_ENTRIES = 4, 6
DIGITS_OF: Mapping[str, int] = MappingProxyType({"sensor_to_body": 9})
"""Field → of its entries: a rotation has to be one to `ROTATION_TOLERANCE`."""
WRITTEN: Mapping[str, str] = MappingProxyType({"rad": "deg", "s": "ms"})
"""SI unit → the one in which a key is written that the file does not have."""
_HEADER = re.compile(r"\s*\[([^\[\]]+)\]\s*(?:#.*)?")
_NUMBER = re.compile(r"(\s*)([\w-]+)(\s*=\s*)(\[[^#]*\]|[^#\s]+)(.*)", re.DOTALL)
_NOTE = "#   {} = "
"""How a provenance note begins the line of a key."""


def _toml_number(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml_number, value))}]"
    return repr(float(value))


def spelling(parameter: Parameter, table: Mapping[str, Any]) -> tuple[str, float]:
    """Return the key that a file has for a parameter, and its factor to SI; else a usual one."""
    accepted = accepted_names(parameter.field)
    for key, factor in accepted.items():
        if key in table:
            return key, factor
    stem, unit = split_unit(parameter.field)
    key = f"{stem}_{WRITTEN[unit]}" if unit in WRITTEN else parameter.field
    return key, accepted[key]


class PenText:
    """The text of a pen file.

    Parameters
    ----------
    text : TOML
    where : the file, for messages
    """

    def __init__(self, text: str, where: str) -> None:
        self.where = where
        self.lines = text.splitlines()
        self.data = toml_data(text, where)
        if isinstance(sensors := self.data.get("sensors"), dict):
            self.data["sensors"] = {plain_name(name): sensors[name] for name in sensors}

    @classmethod
    def of(cls, pen: AnyPen) -> PenText | None:
        """Return the text of a pen's file; None for a pen that is given as data."""
        if isinstance(pen, PenConfig):
            return None
        path = Path(pen)
        if str(pen) in bundled_pens() and not path.is_file():
            path = bundled_pens()[str(pen)]
        where = f"pen file {pen}"
        return cls(read_text(path, where, "a readable TOML file", "toml_bytes"), where)

    def _table(self, table: tuple[str, ...]) -> Mapping[str, Any]:
        found: Any = self.data
        for name in table:
            found = found.get(name, {}) if isinstance(found, dict) else {}
        return found if isinstance(found, dict) else {}

    def spelt(self, parameter: Parameter) -> tuple[str, float]:
        """Return the key of a parameter as the file spells it, with the factor to SI.

        A key that the file leaves to a preset is spelt as a person would write it.
        """
        key, factor = spelling(parameter, self._table(parameter.table))
        if key in self._table(parameter.table):
            return key, factor
        preset = self._table(parameter.table).get("preset")
        return spelling(parameter, presets().get(str(preset), {}))

    def written(self, parameter: Parameter, value: Any) -> Any:
        """Return a value (SI) as it will be read from the file: rounded in the file's unit."""
        factor = self.spelt(parameter)[1]
        return _times(_rounded(value, factor, parameter.field), factor)

    def replaced(self, values: Mapping[Parameter, Any], pen: PenConfig, note: Sequence[str]) -> str:
        """Return the text with other values (SI), and a note on them above its first key.

        A value is a number, or a tuple of values.

        Parameters
        ----------
        pen : what the new text must mean
        note : lines of provenance, without keys, which are added

        Raises
        ------
        InputError
            If the file says a number in a way that cannot be replaced: in an inline table, say.
        """
        lines, old = list(self.lines), OLD_KEY in self.data
        said = {} if old else self.data.get(MOTION, {})
        changed = {p.table[1] for p in values if p.table[:1] == (MOTION,)}
        unsaid = [
            part
            for part in type(pen.motion).model_fields
            if part not in said and (old or part in changed)
        ]
        if old:
            lines = _without_table(lines, OLD_KEY)
        keys = []
        for parameter, value in values.items():
            key, factor = self.spelt(parameter)
            number = _rounded(value, factor, parameter.field)
            keys.append((".".join((*parameter.table, key)), number))
            if parameter.table[:1] != (MOTION,) or parameter.table[1] not in unsaid:
                lines = _with_number(lines, parameter, key, number)
        for part in unsaid:
            lines += _motion_lines(pen, part)
        text = "\n".join(_noted(lines, keys, note)) + "\n"
        try:
            meant = parse_pen(toml_data(text, self.where), self.where)
        except InputError:
            meant = None
        if meant is None or not _same(meant, pen):
            raise InputError(
                f"{self.where}: its numbers cannot be replaced where they stand, expected tables "
                "of their own, as [sensors.accel] and [motion.tip], with a key a line"
            )
        return text


def _rounded(value: Any, factor: float, field: str) -> Any:
    """Return an SI value in a unit, rounded: entries of a list need more digits, one being 1."""
    digits = DIGITS_OF.get(field, DIGITS_OF_ENTRIES) if isinstance(value, tuple) else DIGITS
    return _with_digits(value, factor, digits)


def _with_digits(value: Any, factor: float, digits: int) -> Any:
    if isinstance(value, tuple):
        return tuple(_with_digits(each, factor, digits) for each in value)
    return rounded(value / factor, digits)


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_times(entry, factor) for entry in value)
    return value * factor


def _same(a: PenConfig, b: PenConfig) -> bool:
    """Whether two pens are equal to rounding."""
    return _close(a.model_dump(), b.model_dump())


def _close(a: Any, b: Any) -> bool:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_close(a[key], b[key]) for key in a)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_close, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return a == b or abs(a - b) <= 1e-9 * abs(b)
    return bool(a == b)


def _section(lines: Sequence[str], name: str) -> tuple[int, int] | None:
    """Return the lines (from, to) behind a table's header, up to the next one; "" is on top."""
    start = None if name else 0
    for number, line in enumerate(lines):
        if (header := _HEADER.fullmatch(line)) or line.lstrip().startswith("[["):
            if start is not None:
                return start, number
            if header and plain_name(re.sub(r"[\"']|\s*(?=\.)|(?<=\.)\s*", "", header[1])) == name:
                start = number + 1
    return None if start is None else (start, len(lines))


def _with_number(lines: list[str], parameter: Parameter, key: str, value: Any) -> list[str]:
    """Return lines with a key's number replaced, or added at the end of its table."""
    section = _section(lines, ".".join(parameter.table))
    if section is None:
        return lines
    start, end = section
    for number in range(start, end):
        found = _NUMBER.fullmatch(lines[number])
        if found and found[2] == key:
            indent, _, equals, _, rest = found.groups()
            lines[number] = f"{indent}{key}{equals}{_toml_number(value)}{rest}"
            return lines
    last = max(
        (n for n in range(start, end) if lines[n].strip() and not lines[n].startswith("#")),
        default=start - 1,
    )
    return [*lines[: last + 1], f"{key} = {_toml_number(value)}", *lines[last + 1 :]]


def _without_table(lines: list[str], name: str) -> list[str]:
    section = _section(lines, name)
    return lines if section is None else lines[: section[0] - 1] + lines[section[1] :]


def _motion_lines(pen: PenConfig, part: str) -> list[str]:
    """Return the table of a part of a pen's motion."""
    lines = ["", f"[{MOTION}.{part}]"]
    for key, value in getattr(pen.motion, part):
        if isinstance(value, str):
            lines.append(f'{key} = "{value}"')
        else:
            lines.append(f"{key} = {list(value) if isinstance(value, tuple) else value!r}")
    return lines


def _noted(lines: Sequence[str], keys: Sequence[tuple[str, Any]], note: Sequence[str]) -> list[str]:
    """Return lines with a note behind the comment that the file begins with."""
    old = tuple(_NOTE.format(key) for key, _ in keys)
    kept = [line for line in lines if not line.startswith(old)]
    end = next((n for n, line in enumerate(kept) if not line.startswith("#")), len(kept))
    added = [f"# {line}" for line in note]
    added += [f"{_NOTE.format(key)}{_toml_number(value)}" for key, value in keys]
    return [*kept[:end], *(["#"] if end else []), *added, *kept[end:]]
