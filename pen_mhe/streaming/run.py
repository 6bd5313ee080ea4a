"""A run over a recording in parts: memory does not grow with it.

The recording is read twice (a causal run: three times). First it is checked as a whole recording
is, and counted; then an estimator is driven over it, its output written and its figures summed up.
What `pen_mhe.estimate_run.estimate_recording` says of the whole is the same, row by row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np
import pandas as pd

from estimation.driven import Driven
from estimation.estimate import EstimateHistory
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel
from pen_mhe.chosen_model import chosen_model
from pen_mhe.estimators import DEFAULT_ESTIMATOR, create_estimator
from pen_mhe.no_pen.rest_sensor import with_rest
from pen_mhe.run_summary import RunSummary
from pen_mhe.streaming.drawn import DrawnRows
from pen_mhe.streaming.judging import Judging
from pen_mhe.streaming.plan import planned_as_arrived, planned_at_capture
from pen_mhe.streaming.recent import Recent
from pen_mhe.streaming.rows import stacked_parts
from pen_mhe.streaming.survey import surveyed
from pen_mhe.unseen import output_table
from pen_mhe.watching import as_asked
from recordings.formats.table_stream import TableStream
from recordings.parts import KeptFrames, UsedParts
from recordings.thinning import CameraThinning, kept_of, thinned_camera

Reporting = Callable[[str], AbstractContextManager[Callable[[int], Callable[[int], None]]]]
"""Takes what is done, and is a context with a function that takes how many steps there will be and
returns what is called as they are made."""


def silent(_: str) -> AbstractContextManager[Callable[[int], Callable[[int], None]]]:
    """Report nothing; a `Reporting`."""
    return nullcontext(lambda total: lambda steps: None)


def estimate_stream(
    stream: TableStream,
    pen: PenConfig,
    write: Callable[[pd.DataFrame], None],
    *,
    estimator: str = DEFAULT_ESTIMATOR,
    settings: Mapping[str, Any] | None = None,
    sensors: Sequence[str] | None = None,
    thinning: CameraThinning | None = None,
    duration_s: float | None = None,
    writing_area: bool = True,
    rest: bool = True,
    causal: bool = False,
    watch: bool | None = None,
    on_lost: str | None = None,
    drawn: DrawnRows | None = None,
    reporting: Reporting = silent,
) -> RunSummary:
    """Estimate a recording in parts; see `pen_mhe.estimate_run.estimate_recording`.

    Parameters
    ----------
    write : takes the rows of the output, part by part, all with the same columns
    drawn : keeps what a figure draws
    reporting : of reading the recording, and of the estimator's steps

    Raises
    ------
    InputError
        If the recording is none, or something given makes no sense.
    """
    first = next(iter(stream.parts()), None) if rest else None
    pen, of_rest = (pen, ()) if first is None else with_rest(pen, first, sensors=sensors)
    model = chosen_model(
        pen, tuple(stream.header.sensors), sensors=sensors, writing_area=writing_area, rest=rest
    )
    frames = None if thinning is None else _kept_frames(model, thinning)
    measured, given = [sensor.name for sensor in model.measured_sensors], dict(settings or {})

    def used() -> UsedParts:
        return UsedParts(measured, frames=frames, duration_s=duration_s)

    with reporting("reading") as start:
        survey = surveyed(
            stream,
            pen,
            model,
            used(),
            thinned=None if frames is None else frames.camera,
            on_read=_in_percent(start(100)),
        )
        if causal:
            on_read = _in_percent(start(100))
            plan = planned_as_arrived(
                survey, model, estimator, given, stream=stream, used=used(), on_read=on_read
            )
        else:
            plan = planned_at_capture(survey, model, estimator, given)
    built = as_asked(create_estimator(estimator, model, **plan.settings), watch, False, on_lost)
    judging = Judging(model, instants=survey.instants, true_names=stream.header.truth_names)
    recent, samples = Recent(survey.fastest), 0
    with reporting(estimator) as start:
        driven = Driven(built, on_progress=start(plan.steps), covariances=judging.knows_states)
        for part, rows in stacked_parts(stream, used(), plan.order):
            if part is not None:
                recent.add(part)
                judging.read(part)
                if drawn is not None:
                    drawn.read(part.raw.truth)
            if not len(rows):
                continue
            history = driven.take(rows)
            told, times = plan.telling.take(history, recent.times), recent.times
            output = told.at(times[np.isin(times, told.time_s)])
            judging.step(history)
            judging.tell(told, recent.truth)
            if len(output):
                write(_table(model, output, plan.tells_arrival))
            if drawn is not None:
                drawn.tell(output)
            samples += len(output)
            recent.forget(plan.telling.since_s)
    return judging.summary(
        recording=stream.header.name,
        estimator=built.name,
        samples=samples,
        zero_delay=() if causal else tuple(s.name for s in model.sensors if s.delay_s > 0),
        delays_s=survey.delays_s,
        is_causal=causal,
        lag_samples=plan.lag,
        rows_without=survey.samples - samples,
        notes=(*stream.notes, *of_rest),
        findings=survey.findings,
    )


def _kept_frames(model: StateSpaceModel, thinning: CameraThinning) -> KeptFrames:
    camera = thinned_camera(model)
    return KeptFrames(camera, kept_of(camera, thinning), thinning.phase)


def _table(model: StateSpaceModel, output: EstimateHistory, tells_arrival: bool) -> pd.DataFrame:
    """Return a part of the output, with the arrivals that the whole of it has a column of."""
    table = output_table(model, output)
    if tells_arrival and "arrival_s" not in table.columns:
        table.insert(1, "arrival_s", output.arrival_s)
    return table


def _in_percent(advance: Callable[[int], None]) -> Callable[[float], None]:
    """Return what reports a fraction as whole hundredths since the last call."""
    told = 0

    def report(fraction: float) -> None:
        nonlocal told
        advance(int(100 * fraction) - told)
        told = int(100 * fraction)

    return report
