"""Long commands of many runs: what was done by the same build is not done again.

A file of JSON has a line for each run, and is written whole behind each of them; it can be
interrupted at any time.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Hashable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import ClassVar, Protocol, TypeVar

from estimation.output_file import check_file, write_whole
from models.errors import InputError
from suites.faults.protocol import ESTIMATORS, SENSORS


class KeptRun(Protocol):
    """A run, and what came of it."""

    __dataclass_fields__: ClassVar[dict]  # type: ignore[type-arg]

    @property
    def build(self) -> str:
        """Of the code that ran."""

    @property
    def key(self) -> Hashable:
        """What was run, by which build."""


RunT = TypeVar("RunT", bound=KeptRun)


def parser_of(about: str | None) -> argparse.ArgumentParser:
    """Return a parser of what such a command is asked: for whom, and where its runs are kept."""
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--estimators", nargs="+", choices=ESTIMATORS, default=["ekf"])
    parser.add_argument("--sensors", nargs="+", choices=SENSORS, default=SENSORS)
    parser.add_argument("--output", type=Path, required=True)
    return parser


def kept(path: Path, kind: type[RunT]) -> list[RunT]:
    """Return the runs of a file; none where there is none.

    Raises
    ------
    InputError
        If it holds anything else.
    """
    if not path.exists():
        return []
    try:
        return [kind(**json.loads(line)) for line in path.read_text("utf-8").splitlines()]
    except (ValueError, TypeError):
        raise InputError(f"{path} is not of this command, expected a new file") from None


def all_runs(
    path: Path, build: str, wanted: Iterable[RunT], made: Callable[[RunT], RunT], kind: type[RunT]
) -> list[RunT]:
    """Make the runs that a file of the same build lacks; return all of them.

    Parameters
    ----------
    made : makes a run; returns it with what came of it

    Raises
    ------
    InputError
        If the file holds anything else, or cannot be written; nothing has run then.
    """
    check_file(path)
    done = [run for run in kept(path, kind) if run.build == build]
    keys = {run.key for run in done}
    for run in wanted:
        if run.key not in keys:
            done.append(made(run))
            write_whole(path, "".join(f"{json.dumps(asdict(each))}\n" for each in done))
    return done
