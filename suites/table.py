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
        "real": "suites.real.suite",
    }
)
"""Suite → module that has it as `SUITE`."""


@cache
def find_suite(name: str) -> Suite:
    """Return a suite by name; raises `InputError` for an unknown one."""
    if name not in MODULES:
        raise unknown("suite", name, MODULES)
    suite: Suite = import_module(MODULES[name]).SUITE
    return suite
