"""A run in a process of its own, for a test to kill: FOLDER NOTES JOBS TASKS [SCHEDULER]."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmark.runner.run import Workers, run_tasks
from benchmark.tasks.suite import Scope
from tests.benchmark.runner.workload import figures_noted, no_identity, tasks


def main() -> None:
    folder, notes, jobs, n, *scheduler = sys.argv[1:]
    run_tasks(
        tasks(int(n)),
        Scope(data=notes),
        Workers(int(jobs), *scheduler),
        Path(folder),
        lambda total: print(f"to run: {total}", flush=True) or (lambda done: None),
        figures_noted,
        no_identity,
    )
    print("finished")


if __name__ == "__main__":
    main()
