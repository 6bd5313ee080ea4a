"""Fit noise levels, walks and chains of a pen to a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.errors import InputError, Interrupted
from models.names import unknown
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen, pen_name
from pen_mhe.tuning.levels import LevelFilter
from pen_mhe.tuning.objectives import OBJECTIVES
from pen_mhe.tuning.parameters import Parameter, chosen_parameters, with_values
from pen_mhe.tuning.parts import PARTS, ScoredPart
from pen_mhe.tuning.pen_text import PenText
from pen_mhe.tuning.result import TunedNumber, Tuning
from pen_mhe.tuning.score import Judge
from pen_mhe.tuning.search import Search
from recordings.asked import ColumnsAsked
from recordings.read import RecordingPath, read_recording

DEFAULT_OBJECTIVE = "innovations"
DEFAULT_FIT, DEFAULT_SCORE = "first-half", "second-half"


def tune(
    recording: Recording | RecordingPath,
    pen: AnyPen = "reference",
    *,
    objective: str = DEFAULT_OBJECTIVE,
    sensors: Sequence[str] | None = None,
    parameters: Sequence[str] | None = None,
    fit: str = DEFAULT_FIT,
    score: str = DEFAULT_SCORE,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
    writing_area: bool = True,
    on_progress: Callable[[int, float], None] | None = None,
) -> Tuning:
    """Fit noise levels, walks and chain parameters of a pen to one part of a recording.

    Neither ink nor truth takes part. What the numbers are worth is said of the other part.

    Parameters
    ----------
    recording : a recording, or the path of one
    pen : a pen, the name of a bundled one, or the path of a pen file
    objective : one of `pen_mhe.tuning.objectives.OBJECTIVES`
    sensors : names from the pen file; None takes all that the recording has, without contact
        where the objective withholds it
    parameters : keys of the pen file, in any unit, or their beginnings (``motion``,
        ``sensors.camera``); None takes those that the objective is good for
    fit, score : parts of the recording, `pen_mhe.tuning.parts.PARTS`
    units, columns, strict : of a file, see `recordings.read.read_written`
    writing_area : see `models.pen.pen_model`
    on_progress : called with the number of evaluations and the best value

    Returns
    -------
    The pen with its numbers, which shows itself as a table, and writes itself as a pen file.

    Raises
    ------
    InputError
        If a name is unknown, the objective's data are absent, or nothing is to be tuned.
    """
    if objective not in OBJECTIVES:
        raise unknown("objective", objective, OBJECTIVES)
    for part_name in (fit, score):
        if part_name not in PARTS:
            raise unknown("part", part_name, PARTS)
    row, config, text = OBJECTIVES[objective], as_pen(pen), PenText.of(pen)
    if not isinstance(recording, Recording):
        recording = read_recording(recording, config, units=units, columns=columns, strict=strict)
    used = _used_sensors(config, recording, objective, sensors)
    filtered = LevelFilter(config, used, writing_area=writing_area)
    measured = [s.name for s in filtered.base.model.measured_sensors]
    available = [p for p in filtered.parameters if p.table[0] == "motion" or p.table[1] in measured]
    proposed = [p for p in available if row.proposes(p)]
    chosen = tuple(proposed) if parameters is None else chosen_parameters(available, parameters)
    if not chosen:
        raise InputError(
            f"objective {objective} is good for none of {', '.join(p.key for p in available)}, "
            "expected parameters by name"
        )

    def part(name: str) -> ScoredPart:
        return ScoredPart.of(recording, name, pen=config, model=filtered.base.model)

    judge, others = row.judge(part(fit)), _judges(part(score), objective)
    search = _searched(filtered, judge, chosen, objective, on_progress)
    before = {p: p.value(config) for p in chosen}
    after = dict(zip(chosen, map(float, search.best), strict=True))
    ranges = search.ranges()
    if text is not None:
        after = {p: text.written(p, value) for p, value in after.items()}
    tuned = with_values(config, after)
    factors = {p: text.spelt(p) if text else (p.field, 1.0) for p in chosen}
    return Tuning(
        pen=tuned,
        objective=objective,
        sensors=tuple(used),
        fit=fit,
        score=score,
        recording_name=recording.name,
        pen_name=pen_name(pen),
        numbers=tuple(
            TunedNumber(
                ".".join((*p.table, factors[p][0])),
                *(v / factors[p][1] for v in (before[p], after[p], *ranges[i])),
            )
            for i, p in enumerate(chosen)
        ),
        fitted=(judge(filtered.history, config), judge(filtered.history, tuned)),
        scores={
            name: (other(filtered.history, config), other(filtered.history, tuned))
            for name, other in others.items()
        },
        evaluations=search.evaluations,
        values=after,
        text=text,
    )


def _used_sensors(
    pen: PenConfig, recording: Recording, objective: str, sensors: Sequence[str] | None
) -> list[str]:
    withheld = OBJECTIVES[objective].withholds_touch
    if sensors is None:
        found = [
            name
            for name, sensor in pen.sensors.items()
            if name in recording.readings and not (withheld and sensor.reads_touch)
        ]
        if not found:
            raise InputError(f"recording {recording.name} has no sensor of pen {pen.name}")
        return found
    for name in sensors:
        if withheld and name in pen.sensors and pen.sensors[name].reads_touch:
            raise InputError(
                f"sensor {name} is what {objective} judges by, expected sensors without it"
            )
    return list(sensors)


def _judges(part: ScoredPart, objective: str) -> dict[str, Judge]:
    """Return the judges of a part that it has data for, the objective's own first."""
    judges = {objective: OBJECTIVES[objective].judge(part)}
    for name, row in OBJECTIVES.items():
        has_touch = any(part.pen.sensors[s.name].reads_touch for s in part.model.measured_sensors)
        if name in judges or (row.withholds_touch and has_touch):
            continue
        try:
            judges[name] = row.judge(part)
        except InputError:  # its data are absent, which is no fault of another objective
            continue
    return judges


def _searched(
    filtered: LevelFilter,
    judge: Judge,
    chosen: Sequence[Parameter],
    objective: str,
    on_progress: Callable[[int, float], None] | None,
) -> Search:
    """Return a search that is done; one that is interrupted says what it has found."""

    def value(numbers: Array) -> tuple[float, float]:
        pen = with_values(filtered.pen, dict(zip(chosen, numbers.tolist(), strict=True)))
        score = judge(filtered.history, pen)
        return score.value, score.loss

    start = np.array([p.start(filtered.pen) for p in chosen])
    search = Search(value, start, on_progress)
    try:
        search.run()
    except KeyboardInterrupt:
        best = ", ".join(f"{p.key} {x:.4g}" for p, x in zip(chosen, search.best, strict=True))
        raise Interrupted(
            f"interrupted after {search.evaluations} evaluations; nothing is written; "
            f"best so far, {search.best_value:.6g} {OBJECTIVES[objective].unit}: {best}"
        ) from None
    return search
