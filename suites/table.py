"""The table of suites. A suite exists for runner, report and command line with its row here."""

from __future__ import annotations

from collections.abc import Mapping
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
"""Suite → module that has it as `SUITE`."""


OWN_PEN = "own-pen"
ASKED_FOR: Mapping[str, str] = MappingProxyType({OWN_PEN: "suites.own_pen.suite"})
"""Suites about something of one's own, which run only where it is given."""


@cache
def find_suite(name: str) -> Suite:
    """Return a suite by name; raises `InputError` for an unknown one."""
    modules = {**MODULES, **ASKED_FOR}
    if name not in modules:
        raise unknown("suite", name, MODULES)
    suite: Suite = import_module(modules[name]).SUITE
    return suite
