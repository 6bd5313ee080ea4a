"""Vectors in brackets: ``1000,[0.1, 0.2, 9.8],[0,0,0]``, ``"[0.1 0.2 9.8]"``, ``(0.1, 0.2, 9.8)``.

So Python prints lists, tuples and NumPy's arrays, and pandas writes columns of them
(``numpy.array2string``; ``DataFrame.to_csv`` quotes what holds a comma). Brackets are opened, and a
column's name stands for each of its axes.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from recordings.foreign.header_units import split_header
from recordings.foreign.sniffing import DELIMITERS, split_cells
from recordings.formats.serial_lines import LEAST_ALIKE, LineForm

_DIGITS = r"[+-]?(?:\d++\.?+\d*+|\.\d++|nan)(?:[eE][+-]?\d++)?"
_VECTOR = re.compile(
    rf"\"?(?:np\.)?(?:array)?[\[(]{{1,2}}\s*({_DIGITS}(?:[\s,;]+{_DIGITS}){{1,5}})\s*[\])]{{1,2}}\"?"
)
_PLACE = "\N{SYMBOL FOR SUBSTITUTE}"
"""Stands for a vector while a line is split into cells."""
_AXES = "xyz"


@dataclass(frozen=True)
class Bracketed:
    """Rows of which some cells are vectors.

    Parameters
    ----------
    delimiter : between cells
    sizes : of the vectors of each cell, 0 where it is a number
    above : the line that names the cells; None where none does
    """

    delimiter: str
    sizes: tuple[int, ...]
    above: str | None
    names: tuple[str, ...] | None = None
    said: tuple[str, ...] = ("vectors in brackets, a column an axis",)
    ends_lines: bool = False

    def rows(self, lines: Iterable[str]) -> Iterator[str]:
        """See `LineForm`: a line with fewer vectors, or cut within one, is none."""
        for line in lines:
            cells, vectors = _opened(line, self.delimiter)
            if line == self.above:
                yield ",".join(_names(cells, self.sizes))
            elif _sizes(cells, vectors) != self.sizes:
                yield line.replace(",", " ").replace(self.delimiter, " ")
            else:
                given = iter(vectors)
                yield ",".join(
                    part for cell in cells for part in (next(given) if cell == _PLACE else [cell])
                )


def bracketed_form(lines: Sequence[str]) -> LineForm | None:
    """Return the form of lines with vectors in brackets; None where most have none."""
    told = [line for line in lines if line.strip()]
    of_vectors = [line for line in told if _VECTOR.search(line)]
    if len(of_vectors) <= LEAST_ALIKE * len(told):
        return None
    found: list[tuple[int, str, tuple[int, ...]]] = []
    for delimiter in DELIMITERS:
        sizes = Counter(_sizes(*_opened(line, delimiter)) for line in of_vectors)
        alike, n = sizes.most_common(1)[0]
        if any(alike):
            found.append((n, delimiter, alike))
    n, delimiter, sizes_of = max(found, key=lambda one: (one[0], len(one[2])), default=(0, "", ()))
    if n < LEAST_ALIKE * len(of_vectors):
        return None
    start = lines.index(of_vectors[0])
    above = lines[start - 1] if start else ""
    is_header = len(split_cells(above, delimiter)) == len(sizes_of) and bool(above.strip())
    return Bracketed(delimiter, sizes_of, above if is_header else None)


def _opened(line: str, delimiter: str) -> tuple[list[str], list[list[str]]]:
    """Return a line's cells, with a place for each vector, and the vectors' numbers."""
    vectors = [re.split(r"[\s,;]+", found[1]) for found in _VECTOR.finditer(line)]
    return split_cells(_VECTOR.sub(_PLACE, line), delimiter), vectors


def _sizes(cells: Sequence[str], vectors: Sequence[Sequence[str]]) -> tuple[int, ...]:
    """Return how many numbers each cell has if a vector, else 0; nothing where one is in words."""
    sizes = iter(map(len, vectors))
    if sum(cell == _PLACE for cell in cells) != len(vectors):
        return ()
    return tuple(next(sizes) if cell == _PLACE else 0 for cell in cells)


def _names(above: Sequence[str], sizes: Sequence[int]) -> list[str]:
    names: list[str] = []
    for name, size in zip(above, sizes, strict=True):
        stem, unit = split_header(name)
        written = "" if unit is None else f" [{unit.name}]"
        axes = _AXES if size == len(_AXES) else [str(k) for k in range(1, size + 1)]
        names += [f"{stem} {axis}{written}" for axis in axes] if size else [name]
    return [name.replace(",", " ") for name in names]
