"""Names that help texts list and a shell completes: found only when they are asked for.

A help text says ``{estimators}``; the names stand there when the help is printed. What
a name costs to find is not paid by commands that do not need it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, get_args

import typer

from models.bundled import bundled_pens, sensor_names
from recordings.motion_list import motion_names
from suites.table import BY_NAME, MODULES, NAMED, OF_OWN_PEN


def _estimators() -> Iterable[str]:
    from pen_mhe.estimators import ESTIMATORS  # slow to import, as those below are

    return ESTIMATORS


def _arrival_costs() -> Iterable[str]:
    from mhe.arrival_cost import ARRIVAL_COSTS

    return ARRIVAL_COSTS


def _exportable() -> Iterable[str]:
    from codegen.exportable import EXPORTABLE

    return EXPORTABLE


def _default_export() -> Iterable[str]:
    from codegen.exportable import DEFAULT_EXPORT

    return (DEFAULT_EXPORT,)


def _finds() -> Iterable[str]:
    from pen_mhe.calibration.gravity import COUNTS

    return COUNTS


def _stamps() -> Iterable[str]:
    from recordings.simulate_pen import Stamps

    return get_args(Stamps)


LISTS: Mapping[str, Callable[[], Iterable[str]]] = MappingProxyType(
    {
        "pens": bundled_pens,
        "motions": motion_names,
        "estimators": _estimators,
        "arrival_costs": _arrival_costs,
        "exportable": _exportable,
        "default_export": _default_export,
        "suites": lambda: MODULES,
        "suites_by_name": lambda: BY_NAME,
        "stamps": _stamps,
        "finds": _finds,
        "own_pen": lambda: OF_OWN_PEN,
    }
)
"""Name of a list in a help text → its names."""


def filled(text: str) -> str:
    """Put names where a help text says ``{list}``."""
    for key, names in LISTS.items():
        if (place := f"{{{key}}}") in text:
            text = text.replace(place, ", ".join(names()))
    return text


def completing(key: str) -> Callable[[str], list[str]]:
    """Return a completer of one name of a list, for ``typer.Option(autocompletion=…)``."""

    def complete(incomplete: str) -> list[str]:
        return [name for name in LISTS[key]() if name.startswith(incomplete)]

    return complete


def completing_several(key: str) -> Callable[[str], list[str]]:
    """Return a completer of several names of a list with commas."""

    def complete(incomplete: str) -> list[str]:
        return _next_names(incomplete, LISTS[key]())

    return complete


def complete_sensors(ctx: typer.Context, incomplete: str) -> list[str]:
    """Complete names of sensors with commas: of the pen before them, or of every bundled pen."""
    given: Any = ctx.params.get("pen")
    pens = bundled_pens() if given is None else [str(given)]
    return _next_names(incomplete, [name for pen in pens for name in sensor_names(pen)])


def complete_cases(ctx: typer.Context, incomplete: str) -> list[str]:
    """Complete names of cases with commas: of the suites before them, or of those that run anyway.

    A name that holds a comma stands in double quotes.
    """
    from benchmark.tasks.suite import Scope
    from suites.execute import chosen_tasks

    data = ctx.params.get("data")
    # While an option lacks its value, arguments are left over: they are no parameters yet.
    suites = [name for name in ctx.args if name in NAMED]
    tasks = chosen_tasks(suites or list(MODULES), Scope(data=None if data is None else str(data)))
    cases = [task.case for task in tasks]
    return _next_names(incomplete, [f'"{case}"' if "," in case else case for case in cases])


def _next_names(incomplete: str, names: Iterable[str]) -> list[str]:
    """Return ``accel,gyro`` for ``accel,gy``: what may stand behind the last comma of a list."""
    before = re.match(r'((?:"[^"]*"|[^",]*),)*', incomplete)[0]  # type: ignore[index]
    last, given = incomplete.removeprefix(before), re.findall(r'"[^"]*"|[^",]+', before)
    return [
        f"{before}{name}"
        for name in dict.fromkeys(names)
        if name.startswith(last) and name not in given
    ]
