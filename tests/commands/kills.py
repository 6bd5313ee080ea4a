"""Kills commands at random moments, and reads what is there then.

Every command has two variants, whose results differ. The first variant's results are there when
the second runs and is killed: each file must then be the old one or the new one, whole. After all,
the second runs to its end, and nothing half made is left. As a program, with the number of kills::

    python -m tests.commands.kills 200
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

from benchmark.runner.outcome_lines import outcome_journal
from benchmark.tasks.results import TIMING_COLUMNS
from benchmark.tasks.task import Task
from commands import benchmark_run
from commands.cli import app
from estimation.recording import Recording
from models.pen_file import load_pen
from recordings.formats.tables import recording_to_table, write_table
from tests.pen_mhe.calibration.poses import TWENTY, board

TASKS = [Task("pen", "start 0 deg", "accel", "ekf", seed) for seed in range(6)]
TIMES = {"step_time_s", *TIMING_COLUMNS}
LATE = 0.5
"""Part of the kills that come in the last fifth of a command's time, where it writes."""


@dataclass(frozen=True)
class Killed:
    """A command that is killed.

    Parameters
    ----------
    words : number of the variant → words of the command
    written : files and folders that it writes
    """

    words: Callable[[int], tuple[str, ...]]
    written: tuple[str, ...]


EXPORT = ("codegen", "--sensors", "accel", "--estimator", "ekf", "--output", "c", "--prefix")
COMMANDS: Mapping[str, Killed] = {
    "simulate": Killed(
        lambda n: ("simulate", "--duration", "20", "--seed", str(n), "--output", "sim.csv"),
        ("sim.csv",),
    ),
    "estimate": Killed(
        lambda n: (
            *("estimate", f"rec{n}.csv", "--pen", "reference", "--estimator", "ekf"),
            *("--output", "est.csv", "--figure", "est.png"),
        ),
        ("est.csv", "est.png"),
    ),
    "estimate parquet": Killed(
        lambda n: (
            *("estimate", f"rec{n}.csv", "--pen", "reference", "--estimator", "mhe-rti"),
            *("--output", "est.parquet"),
        ),
        ("est.parquet",),
    ),
    "codegen": Killed(lambda n: (*EXPORT, "pen", *(("--float32",) if n else ())), ("c",)),
    "tune": Killed(
        lambda n: (
            *("tune", f"still{n}.csv", "--pen", "dpoint", "--sensors", "gyro", "--parameters"),
            *("sensors.gyro.noise_density_mdeg_s_per_sqrt_hz", "--output", "tuned.toml"),
        ),
        ("tuned.toml",),
    ),
    "calibrate": Killed(
        lambda n: (
            *("calibrate", "still", f"poses{n}.csv", "--pen", "reference", "--find", "bias"),
            *("--output", "still.toml"),
        ),
        ("still.toml",),
    ),
    "benchmark": Killed(
        lambda n: ("benchmark", "pen", "--jobs", "1", "--seeds", str(n + 1), "--output", "r"),
        ("r",),
    ),
    "report": Killed(lambda n: ("report", f"r{n}", "--pictures", "p"), ("r0", "r1", "p")),
}


def prepare(folder: Path) -> None:
    """Write what the commands read, and run every variant once."""
    os.chdir(folder)
    for n in range(2):
        rng = np.random.default_rng(n)
        times = np.arange(0.0, 9.0, 0.05)
        rates = 0.01 * rng.standard_normal((len(times), 3))
        still = Recording.from_sensors("still", {"gyro": (times, rates)})
        write_table(recording_to_table(still, load_pen("dpoint")), Path(f"still{n}.csv"))
        poses = board(n + 1, TWENTY, rest_s=2.0).recording
        write_table(recording_to_table(poses, load_pen("reference")), Path(f"poses{n}.csv"))
        run(("simulate", "--duration", "4", "--seed", str(n), "--output", f"rec{n}.csv"))


def run(words: tuple[str, ...], after_s: float | None = None) -> float:
    """Run a command in a child; kill it after a time. Returns how long it ran."""
    start = time.perf_counter()
    child = os.fork()
    if not child:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
        code = 1
        try:
            app(list(words), prog_name="pen-mhe")
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            os._exit(code)
    if after_s is not None:
        time.sleep(after_s)
        os.kill(child, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert code == 0 or (after_s is not None and code == -signal.SIGKILL), (words, code)
    return time.perf_counter() - start


def read(path: Path) -> object:
    """Return what a file says, apart from times; raises what a damaged one makes of itself."""
    if path.suffix in (".csv", ".parquet"):
        table = pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path)
        return table.drop(columns=[name for name in table if name in TIMES]).to_csv()
    if path.suffix == ".png":
        with Image.open(path) as image:
            image.load()
            return image.size
    if path.name == "run.json":
        return sorted(json.loads(path.read_text("utf-8")))
    if path.name == "report.html":
        text = path.read_text("utf-8")
        assert text.startswith("<!")
        assert text.rstrip().endswith("</html>")
        return "a page"
    if path.name == "report.md":
        assert path.read_text("utf-8").endswith("\n")
        return "a text"
    if path.suffix == ".toml":
        load_pen(path)
    return path.read_bytes()


def results(folder: Path, written: tuple[str, ...]) -> dict[str, object]:
    """Return what all files of a command say, without journals and what is half made."""
    tops = [folder / name for name in written]
    paths = [path for top in tops for path in (top, *sorted(top.rglob("*")))]
    return {
        path.relative_to(folder).as_posix(): read(path)
        for path in paths
        if path.is_file() and not path.name.endswith((".part", ".lock", ".jsonl"))
    }


def copy(source: Path, target: Path, written: tuple[str, ...]) -> None:
    for name in written:
        shutil.rmtree(target / name, ignore_errors=True)
        (target / name).unlink(missing_ok=True)
        if (source / name).is_dir():
            shutil.copytree(source / name, target / name)
        elif (source / name).exists():
            shutil.copy(source / name, target / name)


@dataclass
class Tally:
    """What was found after the kills."""

    kills: int = 0
    old: int = 0
    new: int = 0
    between: int = 0
    left: int = 0
    faults: list[str] = field(default_factory=list)


def kill_all(kills: int, seed: int, folder: Path) -> Tally:
    """Kill the commands in turn at random moments; see the module."""
    rng, tally = random.Random(seed), Tally()
    benchmark_run.chosen_tasks = lambda suites, scope: TASKS[: 3 * scope.seeds]  # type: ignore[assignment]
    prepare(folder)
    kept: dict[str, tuple[Path, Path]] = {}
    found: dict[str, list[dict[str, object]]] = {}
    lasts: dict[str, float] = {}
    for name, command in COMMANDS.items():
        if name == "report":
            for n in range(2):
                shutil.copytree(kept["benchmark"][n] / "r", folder / f"r{n}")
        kept[name] = (folder / f"{name}-0", folder / f"{name}-1")
        found[name] = []
        for n, place in enumerate(kept[name]):
            place.mkdir()
            run(command.words(n))
            lasts[name] = run(command.words(n)) if name != "benchmark" else 0.0
            copy(folder, place, command.written)
            found[name].append(results(place, command.written))
        if name == "benchmark":
            shutil.rmtree(folder / "r")
            lasts[name] = run(command.words(1))
    names = list(COMMANDS)
    for number in range(kills):
        name = names[number % len(names)]
        command = COMMANDS[name]
        copy(kept[name][0], folder, command.written)
        is_late = rng.random() < LATE
        after_s = lasts[name] * (rng.uniform(0.8, 1.05) if is_late else rng.uniform(0.0, 1.0))
        run(command.words(1), after_s)
        judge(tally, f"{name} after {after_s:.3f} s", folder, command, found[name])
        if number >= kills - len(names):
            run(command.words(1))
            judge(tally, f"{name} again", folder, command, [found[name][1]] * 2)
            if left := half_made(folder, command):
                tally.faults.append(f"{name}: {left} left")
    return tally


def judge(
    tally: Tally,
    what: str,
    folder: Path,
    command: Killed,
    variants: list[dict[str, object]],
) -> None:
    """Compare what is there with the old and with the new."""
    old, new = variants
    tally.kills += 1
    try:
        there = results(folder, command.written)
        if "r" in command.written:
            with outcome_journal(folder / "r") as journal:
                assert all(journal.has(task, identity) for task, identity in old_tasks(folder))
    except Exception as error:
        tally.faults.append(f"{what}: {error!r}")
        return
    lost = sorted(old.keys() - there.keys())
    odd = sorted(file for file, said in there.items() if said not in (old.get(file), new.get(file)))
    if lost or odd:
        tally.faults.append(f"{what}: lost {lost}, neither old nor new {odd}")
    tally.left += bool(half_made(folder, command))
    if there == new:
        tally.new += 1
    elif there == old:
        tally.old += 1
    else:
        tally.between += 1


def half_made(folder: Path, command: Killed) -> list[Path]:
    """Return what is half made beside and within what a command writes."""
    found = [path for name in command.written for path in (folder / name).rglob("*.part")]
    return found + [path for name in command.written for path in folder.glob(f".{name}.*.part")]


def old_tasks(folder: Path) -> list[tuple[Task, str]]:
    """Return the tasks that were finished before the kill, with what they were run with."""
    with (folder / "benchmark-0" / "r" / "journal.jsonl").open() as lines:
        parsed = [json.loads(line) for line in lines]
    return [(Task(**line["task"]), line["identity"]) for line in parsed]


def main(kills: int, seed: int = 0) -> Tally:
    """Kill so many commands in a folder that goes afterwards."""
    before = os.getcwd()
    os.environ.pop("PEN_MHE_DATA", None)
    with tempfile.TemporaryDirectory() as folder:
        try:
            return kill_all(kills, seed, Path(folder))
        finally:
            os.chdir(before)


if __name__ == "__main__":
    tally = main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    print(f"{tally.kills} looks: {tally.old} old, {tally.new} new, {tally.between} of both kinds")
    print(f"{tally.left} with something half made beside, which the next run removed")
    print(*tally.faults or ["no fault"], sep="\n")
    sys.exit(bool(tally.faults))
