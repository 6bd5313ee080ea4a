"""Commands of earlier versions, and what does their work now."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from models.errors import InputError

REPLACED: Mapping[str, str] = MappingProxyType(
    {
        "bad-starts": "`pen-mhe benchmark bad-starts`",
        "consistency": "`pen-mhe benchmark consistency`",
        "optimum": "`pen-mhe benchmark optimum --seeds WINDOWS`",
        "printed-cost": "`pen-mhe benchmark printed-cost`",
        "real-time": "`pen-mhe benchmark real-time`",
    }
)
"""Command → the one that replaces it."""


def check_replaced(command: str) -> None:
    """Raise `InputError` for a command that another one replaces."""
    if command in REPLACED:
        raise InputError(f"command {command} is gone, expected {REPLACED[command]}")
