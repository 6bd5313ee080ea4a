"""The tables of suites. One exists for runner, report and command line with its row here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from models.names import unknown

if TYPE_CHECKING:
    from benchmark.tasks.suite import Suite

MODULES: Mapping[str, str] = MappingProxyType(
    {
        "pen": "suites.pen.suite",
        "tilt": "suites.tilt.suite",
        "gyro-free": "suites.gyro_free.suite",
        "classics": "suites.classics.suite",
        "faults": "suites.faults.suite",
        "real": "suites.real.suite",
    }
)
"""Suite → module that has it as `SUITE`: what runs where no suite is named."""

BY_NAME: Mapping[str, str] = MappingProxyType(
    {
        "bad-starts": "suites.bad_starts.suite",
        "consistency": "suites.consistency.suite",
        "optimum": "suites.optimum.suite",
        "printed-cost": "suites.printed_cost.suite",
        "real-time": "suites.real_time.suite",
        "speed": "suites.speed.suite",
    }
)
"""Suites that run only where they are named: they take longer, or ask about the estimators."""

OWN_PEN = "own-pen"
ASKED_FOR: Mapping[str, str] = MappingProxyType({OWN_PEN: "suites.own_pen.suite"})
"""Suites about something of one's own, which run only where it is given."""


@dataclass(frozen=True)
class WithOwnPen:
    """How a suite is asked of a pen of one's own.

    Parameters
    ----------
    suite : that answers
    reads : options of a run, beside the pen, that it reads and others do not
    """

    suite: str
    reads: frozenset[str] = frozenset()


OF_OWN_PEN: Mapping[str, WithOwnPen] = MappingProxyType(
    {
        "pen": WithOwnPen(OWN_PEN, frozenset({"motion", "recording"})),
        "consistency": WithOwnPen("consistency"),
    }
)
"""Suite that can be asked of a pen of one's own → how."""

NAMED: Mapping[str, str] = MappingProxyType({**MODULES, **BY_NAME})
"""Every suite that a run can name."""


@cache
def find_suite(name: str) -> Suite:
    """Return a suite by name; raises `InputError` for an unknown one."""
    modules = {**NAMED, **ASKED_FOR}
    if name not in modules:
        raise unknown("suite", name, NAMED)
    suite: Suite = import_module(modules[name]).SUITE
    return suite
