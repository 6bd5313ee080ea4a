"""How often a watch blames a sensor that is well, along hours of motion without a fault.

    python -m suites.faults.false_alarms --hours 10 --output alarms.jsonl
    python -m suites.faults.false_alarms --hours 2 --estimators mhe-rti --output rti.jsonl

Hours are of each estimator and choice of sensors, a quarter each at 0.3, 1, 2 and 3 times the speed
that the pen file states. Of each part of `PART_S` one half is handwriting, the other a motion
drawn from a model: chains of the hand's RMS speed and rate that do not get faster and faster, as
white jerk would. Seeds are those of no calibration. A line is written after each part; run again,
lines of the same build are kept and only what is missing is done, those of another are forgotten.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from benchmark.configurations import CONFIGURATIONS
from benchmark.runner.identity import code_identity
from estimation.recording import Recording
from estimation.status import Status
from estimation.watch.flags import Flag
from estimation.watch.watched import Watched
from models.errors import InputError
from models.gentle_hand import at_speed, bounded_writing
from models.motion import AttitudeBoundedRate, Motion
from models.pen import pen_model
from models.state_space import StateSpaceModel
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate_model
from suites.faults.cells import Bench, bench_of
from suites.faults.clean import SETTLED_S, SPEEDS
from suites.faults.given_rows import GivenRows
from suites.faults.kept_runs import all_runs, parser_of
from suites.faults.protocol import MOTION, recorded, writers_pen
from suites.faults.said import Said
from suites.faults.scoring import raised

PART_S = 150.0
"""Of one motion, at one speed."""
FIRST_SEED = 20_000
"""Of no other use."""
UNEXPLAINED = "unexplained"
TURNS_S = 0.1
"""A hand keeps its rate of turning so long."""


@dataclass(frozen=True)
class AlarmPart:
    """What a watch said along one motion without a fault.

    Parameters
    ----------
    build : of the code that ran
    lost_s, livelier_s : for how long, behind the first `SETTLED_S`
    raised : sensor, sensor and word, or `UNEXPLAINED` → how often that went up
    first_s : the same → when first
    """

    build: str
    estimator: str
    sensors: str
    motion: str
    speed: float
    seed: int
    lost_s: float = 0.0
    livelier_s: float = 0.0
    raised: dict[str, int] = field(default_factory=dict)
    first_s: dict[str, float] = field(default_factory=dict)

    @property
    def key(self) -> tuple[str, str, str, str, float, int]:
        """What was run."""
        return (self.build, self.estimator, self.sensors, self.motion, self.speed, self.seed)


def wanted(
    build: str, estimators: Sequence[str], sensors: Sequence[str], hours: float
) -> Iterator[AlarmPart]:
    """Yield parts to run, such that whatever ends early is of all speeds and choices alike."""
    each = max(1, round(3600 * hours / (2 * PART_S * len(SPEEDS))))
    for seed in range(FIRST_SEED, FIRST_SEED + each):
        for name in estimators:
            for choice in sensors:
                for speed in SPEEDS:
                    for motion in (MOTION, DRAWN):
                        yield AlarmPart(build, name, choice, motion, speed, seed)


@cache
def drawn_model(sensors: str, speed: float) -> StateSpaceModel:
    """Return a model whose motion is about that of a hand at a factor of its own speed."""
    hand = at_speed("prior", speed)
    turning = AttitudeBoundedRate(
        rate_rad_s=hand["angle_rate_std_rad_s"], correlation_time_s=TURNS_S / speed
    )
    motion = Motion(tip=bounded_writing(speed).tip, attitude=turning)
    pen = writers_pen()
    prior = pen.prior.model_copy(update=hand)
    moved = pen.model_copy(update={"motion": motion, "prior": prior})
    return pen_model(moved, CONFIGURATIONS[sensors].sensors)


def stream_of(part: AlarmPart) -> Recording:
    """Return the readings along a part's motion."""
    if part.motion == DRAWN:
        model = drawn_model(part.sensors, part.speed)
        return simulate_model(model, duration_s=PART_S, seed=part.seed)
    return recorded(part.sensors, part.seed, PART_S, speed=part.speed)


def watched_part(part: AlarmPart) -> AlarmPart:
    """Return a part with what was said."""
    bench: Bench = bench_of(part.estimator, part.sensors, Watched)
    history = bench.history(GivenRows.of(stream_of(part)))
    told, time_s = Said.of(history), history.time_s - history.time_s[0]
    lasting_s = np.diff(time_s, append=time_s[-1])
    found = {UNEXPLAINED: (told.status & Status.INCONSISTENT.value) != 0}
    for name, flags in zip(told.sensor_names, told.flagged.T, strict=True):
        found[name] = flags != 0
        found |= {f"{name}:{flag.word}": (flags & flag.value) != 0 for flag in Flag}
    up = {word: holds for word, holds in found.items() if holds.any()}

    def seconds(status: Status) -> float:
        holds = (told.status & status.value) != 0
        return float(lasting_s[holds & (time_s >= SETTLED_S)].sum())

    return AlarmPart(
        *part.key,
        seconds(Status.LOST),
        seconds(Status.LIVELIER),
        {word: raised(holds) for word, holds in up.items()},
        {word: round(float(time_s[np.argmax(holds)]), 3) for word, holds in up.items()},
    )


def table(parts: Sequence[AlarmPart]) -> str:
    """Return flags per hour and sensor by speed and word, and how long it was lost and livelier."""
    lines = list[str]()
    for estimator, sensors in dict.fromkeys((each.estimator, each.sensors) for each in parts):
        of_it = [each for each in parts if (each.estimator, each.sensors) == (estimator, sensors)]
        lines.append(f"{estimator}, {sensors}")
        for speed in SPEEDS:
            lines.append(_row(f"speed {speed:g}", [p for p in of_it if p.speed == speed], sensors))
        lines.append(_row("all", of_it, sensors))
    return "\n".join(lines)


def _row(head: str, parts: Sequence[AlarmPart], sensors: str) -> str:
    hours, up = len(parts) * PART_S / 3600, Counter[str]()
    if not parts:
        return f"  {head}: nothing yet"
    for part in parts:
        up.update(part.raised)
    names = CONFIGURATIONS[sensors].sensors
    flags = sum(up[name] for name in (*names, UNEXPLAINED)) / (hours * len(names))
    words = ", ".join(f"{word} {up[word] / hours:.3g}/h" for word in sorted(up))
    lost, livelier = (
        100 * sum(seconds) / (3600 * hours)
        for seconds in ([p.lost_s for p in parts], [p.livelier_s for p in parts])
    )
    said = f"{flags:.3g} flags an hour and sensor, lost {lost:.3g} %, livelier {livelier:.3g} %"
    return f"  {head}, {hours:.3g} h: {said}" + (f"; {words}" if words else "")


def main() -> None:
    """Run what is missing, and print what was found."""
    parser = parser_of(__doc__)
    parser.add_argument("--hours", type=float, default=10.0)
    given = parser.parse_args()
    if not 0 < given.hours < math.inf:
        parser.error(f"--hours is {given.hours}, expected a positive number")
    build = code_identity()
    parts = wanted(build, given.estimators, given.sensors, given.hours)
    try:
        print(table(all_runs(given.output, build, parts, watched_part, AlarmPart)))
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
