"""``run.json``: with what, where, from what and for how long a run was made."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import subprocess
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from benchmark.runner.identity import code_identity, task_identity, versions
from benchmark.tasks.suite import Scope
from estimation.native import compiler
from estimation.output_file import write_whole
from models.parsed import check_entries, read_object
from pen_mhe.rooms import ROOT

NAME = "run.json"
CPU_INFO = Path("/proc/cpuinfo")


def about(command: str, suites: list[str], seeds: int) -> dict[str, Any]:
    """Return what is known of a run before its first task."""
    return {
        "command": command,
        "suites": suites,
        "seeds": seeds,
        "code": code_identity(),
        "versions": versions(),
        "machine": machine(),
        "git": git_state(),
        "sessions": [],
    }


def session(
    started: datetime, seconds: float, jobs: str, tasks: int, finished: bool
) -> dict[str, Any]:
    """Return one sitting of a run: a run that was killed and continued has several.

    Parameters
    ----------
    jobs : processes, or the scheduler
    tasks : that it ran
    finished : whether all tasks were finished at its end
    """
    return {
        "started": started.astimezone(UTC).isoformat(timespec="seconds"),
        "seconds": round(seconds, 1),
        "jobs": jobs,
        "tasks": tasks,
        "finished": finished,
    }


def machine() -> dict[str, Any]:
    """Return processor, system and number of cores; nothing that names the machine."""
    return {
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
    }


@cache
def timing_identity(recordings: str = "", scope: Scope | None = None) -> str:
    """Return what a measured time depends on: a task's identity, machine and all packages.

    Parameters
    ----------
    recordings, scope : of `benchmark.runner.identity.task_identity`
    """
    packages = sorted(f"{each.name} {each.version}" for each in distributions())
    here = json.dumps([machine(), platform.python_version(), compiler(), packages])
    of_task = task_identity(recordings, scope or Scope())
    return f"{of_task}-{hashlib.sha256(here.encode()).hexdigest()[:16]}"


def git_state() -> dict[str, Any]:
    """Return commit and whether files differ from it; empty outside a repository."""
    if not (ROOT / ".git").exists():
        return {}
    try:
        commit = _git("rev-parse", "HEAD").strip()
        return {"commit": commit, "dirty": bool(_git("status", "--porcelain", "-uno").strip())}
    except (OSError, subprocess.CalledProcessError):
        return {}


def write_about(run: Mapping[str, Any], folder: Path) -> None:
    """Write ``run.json``."""
    write_whole(folder / NAME, json.dumps(run, indent=2, ensure_ascii=False))


def read_about(folder: Path) -> dict[str, Any]:
    """Read ``run.json``; raises `InputError` where it is missing or no JSON object."""
    path = folder / NAME
    found = read_object(path, "the folder of a run")
    check_entries(found, _ENTRIES, str(path))
    return found


_ENTRIES: Mapping[str, tuple[type, type | None]] = {
    **dict.fromkeys(("command", "again", "answer_is_about", "code"), (str, None)),
    **dict.fromkeys(("suites", "estimators", "cases"), (list, str)),
    **dict.fromkeys(("versions", "machine", "git"), (dict, str)),
    "seeds": (int, None),
    "sessions": (list, dict),
}
"""Entry of ``run.json`` that is read again → its type, and that of its entries or keys."""


def _git(*arguments: str) -> str:
    return subprocess.run(
        ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=True
    ).stdout


def _processor() -> str:
    if CPU_INFO.is_file():
        for line in CPU_INFO.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()
