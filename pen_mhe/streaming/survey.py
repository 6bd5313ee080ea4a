"""What must be known of a recording before it is estimated in parts: one look at all of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from estimation.orders import InOrderOfArrival
from estimation.tallies import Quantiles
from models.errors import InputError
from models.pen_config import PenConfig
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from pen_mhe.causal_run import lateness
from pen_mhe.streaming.recent import Recent
from pen_mhe.streaming.rows import stacked_parts
from recordings.checks.run import findings_of_sketch
from recordings.checks.sketch import Sketch
from recordings.finding import Finding
from recordings.formats.table_stream import TableStream
from recordings.parts import UsedParts
from recordings.recording_check import RecordingCheck
from recordings.thinning import check_rate


@dataclass(frozen=True)
class Survey:
    """A recording at a glance.

    Parameters
    ----------
    instants : of the part that is used
    fastest : the sensor with most readings in it
    samples : how many these are
    delays_s : as of `pen_mhe.causal_run.delays_of`
    findings : what an estimate of it may suffer from
    """

    instants: int
    fastest: str
    samples: int
    delays_s: dict[str, float]
    findings: tuple[Finding, ...]


def surveyed(
    stream: TableStream,
    pen: PenConfig,
    model: StateSpaceModel,
    used: UsedParts,
    *,
    thinned: SensorModel | None = None,
    on_read: Callable[[float], None] | None = None,
) -> Survey:
    """Look at all of a recording, and refuse what is none.

    Parameters
    ----------
    thinned : a camera of which frames are left out: its rate must be that of its pen file
    on_read : see `TableStream.parts`

    Raises
    ------
    InputError
        As `recordings.read.read_written` does, or if nothing is used.
    """
    check, instants = RecordingCheck(stream.header, pen), 0
    readings = {sensor.name: 0 for sensor in model.measured_sensors}
    late: dict[str, Quantiles] = {}
    intervals, last, sketch = Quantiles(), np.zeros(0), Sketch()
    for raw in stream.parts(on_read):
        check.take(raw)
        part = used.take(raw)
        if part is None:
            continue
        sketch.take(part.recorded)
        if thinned is not None:
            times = np.append(last, part.recorded.sensor(thinned.name)[0])
            intervals.add(np.diff(times))
            last = times[-1:]
        if part.used is not None:
            instants += len(part.used.time_s)
            for name in readings:
                readings[name] += len(part.used.sensor(name)[0])
            for name, delays in lateness(model, part.used).items():
                late.setdefault(name, Quantiles()).add(delays)
    check.end()
    if thinned is not None and intervals.count:
        check_rate(thinned, stream.header.name, intervals.median)
    if not instants:
        raise InputError(f"{stream.header.where} is empty, expected at least one sample")
    medians = {name: delays.median for name, delays in late.items()}
    fastest = max(readings, key=lambda name: readings[name])
    return Survey(
        instants,
        fastest,
        readings[fastest],
        {name: delay_s for name, delay_s in medians.items() if delay_s > 0},
        findings_of_sketch(sketch, pen),
    )


@dataclass(frozen=True)
class Arrivals:
    """How the readings of a recording arrive.

    Parameters
    ----------
    steps : rows in order of arrival
    newest : samples of the fastest sensor that were the newest when they arrived
    is_late : whether one of these arrived after its capture
    most_instants : of all sensors that a lag in samples of the fastest one may be
    """

    steps: int
    newest: int
    is_late: bool
    most_instants: int


def surveyed_arrivals(
    stream: TableStream,
    model: StateSpaceModel,
    used: UsedParts,
    *,
    fastest: str,
    lag: int,
    on_read: Callable[[float], None] | None = None,
) -> Arrivals:
    """Look at a recording that `surveyed` takes in the order in which it arrives.

    Parameters
    ----------
    lag : in samples of the fastest sensor
    on_read : see `TableStream.parts`
    """
    recent = Recent(fastest)
    steps, newest, is_late, newest_s = 0, 0, False, -np.inf
    most, instants, rows = 0, 0, np.zeros(0, dtype=int)
    for part, arrived in stacked_parts(stream, used, InOrderOfArrival(model), on_read=on_read):
        if part is not None and part.used is not None:
            recent.add(part)
            times = part.used.sensor(fastest)[0]
            rows = np.append(rows, instants + np.searchsorted(part.used.time_s, times))
            instants += len(part.used.time_s)
            if len(rows) > lag:
                most = max(most, int((rows[lag:] - rows[: len(rows) - lag]).max()))
                rows = rows[len(rows) - lag :]
        ever = np.maximum.accumulate(np.append(newest_s, arrived.time_s))
        on_time = np.flatnonzero(np.diff(ever) > 0)
        on_time = on_time[np.isin(arrived.time_s[on_time], recent.times)]
        is_late |= bool((arrived.arrival_s[on_time] != arrived.time_s[on_time]).any())
        steps, newest, newest_s = steps + len(arrived), newest + len(on_time), float(ever[-1])
        recent.forget(newest_s)
    return Arrivals(steps, newest, is_late, most)
