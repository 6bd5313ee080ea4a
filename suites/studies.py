"""The table of studies: questions with tables of their own, which are no suites yet."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

STUDIES: Mapping[str, str] = MappingProxyType(
    {
    }
)
"""Study → module that runs it. Under its name it is a command and keeps what it has found, see
`benchmark.runner.kept`."""
