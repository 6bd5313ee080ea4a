"""The command that runs, as people may give it again."""

from __future__ import annotations

import os
import shlex
import sys


def command_line() -> str:
    """Return the command that runs, with the data folder named by its variable."""
    words = ["pen-mhe", *sys.argv[1:]]
    data = os.environ.get("PEN_MHE_DATA")
    return shlex.join("$PEN_MHE_DATA" if data and word == data else word for word in words)
