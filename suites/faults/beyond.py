"""Faults that the table does not have: how a watch does on what it was not made for.

    python -m suites.faults.beyond --seeds 3 --output beyond.jsonl

Faults are those of ``beyond.toml``, scored as those of the table are. A line is written after each
run; run again, lines of the same build are kept and only what is missing is done.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchmark.runner.identity import code_identity
from estimation.watch.watched import Watched
from models.errors import InputError
from suites.faults.cells import run_cell
from suites.faults.kept_runs import all_runs, parser_of
from suites.faults.protocol import faults_for
from suites.faults.table import BEYOND, faults

FIRST_SEED = 300
"""Of no other use."""


@dataclass(frozen=True)
class BeyondRun:
    """What came of one fault.

    Parameters
    ----------
    build : of the code that ran
    is_silent : whether the answer was wrong for longer than counts, and nothing was said
    silent_s, peak_stds : for how long in all, and the largest error in claimed deviations
    said : words, with how long each was said
    broke : why the run broke off; empty where it did not
    """

    build: str
    estimator: str
    sensors: str
    fault: str
    seed: int
    is_silent: bool = False
    silent_s: float = 0.0
    peak_stds: float = 0.0
    said: str = ""
    broke: str = ""

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        """What was run."""
        return (self.build, self.estimator, self.sensors, self.fault, self.seed)


def wanted(
    build: str, estimators: Sequence[str], sensors: Sequence[str], seeds: int
) -> Iterator[BeyondRun]:
    """Yield runs to make, seed by seed."""
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        for name in estimators:
            for choice in sensors:
                for fault in faults_for(choice, BEYOND):
                    yield BeyondRun(build, name, choice, fault.key, seed)


def scored(run: BeyondRun) -> BeyondRun:
    """Return a run with what came of it."""
    fault = faults(BEYOND)[run.fault]
    score = run_cell(fault, run.estimator, run.sensors, [run.seed], Watched)[0]
    came = score.is_silent_wrong, score.silent_s, score.peak_stds, score.said, score.broke
    return BeyondRun(*run.key, *came)


def table(runs: Sequence[BeyondRun]) -> str:
    """Return how many runs of each row of the file were wrong in silence, and which."""
    lines = list[str]()
    for estimator in dict.fromkeys(run.estimator for run in runs):
        of_it = [run for run in runs if run.estimator == estimator]
        lines.append(f"{estimator}: silent {_counted(of_it)} runs")
        for name in dict.fromkeys(fault.name for fault in faults(BEYOND).values()):
            of_row = [run for run in of_it if faults(BEYOND)[run.fault].name == name]
            lines.append(f"  {_counted(of_row)}: {name}")
            silent = [f"{run.fault} ({run.sensors})" for run in of_row if run.is_silent]
            lines += [f"    {silent.count(each)} {each}" for each in dict.fromkeys(silent)]
    return "\n".join(lines)


def _counted(runs: Sequence[BeyondRun]) -> str:
    return f"{sum(run.is_silent for run in runs)} of {len(runs)}"


def main() -> None:
    """Run what is missing, and print what was found."""
    parser = parser_of(__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    if given.seeds < 1:
        parser.error(f"--seeds is {given.seeds}, expected a positive number")
    build = code_identity()
    runs = wanted(build, given.estimators, given.sensors, given.seeds)
    try:
        print(table(all_runs(given.output, build, runs, scored, BeyondRun)))
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
