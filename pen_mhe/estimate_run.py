"""The work behind ``pen-mhe estimate``: one recording, one pen, one estimator."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from estimation.estimator import LookingBack, run
from estimation.recording import Recording
from estimation.smoother import smoothed
from models.errors import InputError
from models.limits import check_most, most
from models.pen_config import PenConfig
from models.pen_file import AnyPen
from pen_mhe.causal_run import causal_lags, delays_of, told_at
from pen_mhe.chosen_model import chosen_model
from pen_mhe.estimators import DEFAULT_ESTIMATOR, check_filter, create_estimator
from pen_mhe.no_pen.axis import AnyAxis
from pen_mhe.no_pen.rest_sensor import with_rest
from pen_mhe.no_pen.usual import usual_estimator
from pen_mhe.no_pen.which import pen_and_recording
from pen_mhe.run_figures import has_nees, nees_of, nis_of, true_rms
from pen_mhe.run_result import EstimateRun
from pen_mhe.truth.given import GivenTruth, TruthSource
from pen_mhe.truth.judged import judged_by
from pen_mhe.watching import as_asked
from recordings.asked import ColumnsAsked
from recordings.ink import ink_match
from recordings.read import RecordingPath
from recordings.thinning import CameraThinning, left_out_error, thinned
from recordings.written import WrittenRecording


def estimate_recording(
    loaded: WrittenRecording,
    pen: PenConfig,
    *,
    estimator: str = DEFAULT_ESTIMATOR,
    settings: Mapping[str, Any] | None = None,
    sensors: Sequence[str] | None = None,
    thinning: CameraThinning | None = None,
    duration_s: float | None = None,
    on_start: Callable[[int], Callable[[int], None]] | None = None,
    writing_area: bool = True,
    rest: bool = True,
    smooth: bool = False,
    causal: bool = False,
    watch: bool | None = None,
    on_lost: str | None = None,
    truth: GivenTruth | None = None,
) -> EstimateRun:
    """Estimate a recording and compare with whatever reference it brings.

    Parameters
    ----------
    estimator : one of `pen_mhe.estimators.ESTIMATORS`
    settings : that it reads, by name; see `pen_mhe.estimators.create_estimator`. With
        ``lag_samples`` (the largest of them) output, ink and errors are those at that lag
    sensors : names from the pen file; None takes all that the recording has
    thinning : use fewer camera frames
    duration_s : use only the first seconds
    on_start : called with the number of steps; returns what is called as they are made
    writing_area, rest : see `models.pen.pen_model`; a recording that has readings of the pen's
        sensor of rest (zero where an IMU says that it does not move) tells it instead, and a pen
        without one is given it where the recording is still, see `pen_mhe.no_pen.rest_sensor`
    smooth : go back over a filter's estimates, so that each knows the whole recording; output, ink
        and errors are those
    causal : see `estimation.estimator.run`; ``lag_samples`` are then the fastest sensor's
    watch, on_lost : whether readings are tested and what is then done, see `pen_mhe.watching`;
        by default it is watched, unless it is smoothed
    truth : from elsewhere, which the output is compared with; no estimator sees it

    Raises
    ------
    InputError
        If no chosen sensor has readings of its own, or something given makes no sense.
    """
    if smooth:
        check_filter(estimator)
        if causal:
            raise InputError(
                "a run is causal and smooth, expected one: smoothing knows the whole recording"
            )
        check_most(
            "smoothed_rows", len(loaded.recording.time_s), f"recording {loaded.recording.name}"
        )
    track = None if truth is None else truth.track(pen, loaded.origin_s)
    recording = loaded.recording
    pen, of_rest = with_rest(pen, recording, sensors=sensors) if rest else (pen, ())
    model = chosen_model(
        pen, tuple(recording.readings), sensors=sensors, writing_area=writing_area, rest=rest
    )
    measured = [sensor.name for sensor in model.measured_sensors]
    recorded = recording.select(measured)
    if duration_s is not None:
        if not duration_s > 0:
            raise InputError(f"duration is {duration_s:g} s, expected a positive time")
        recorded = recorded.first(duration_s)
    cameras = [s for s in model.sensors if s.sees_pose]
    used = recorded if thinning is None else thinned(model, recorded, thinning)
    fastest = max(measured, key=lambda name: len(used.sensor(name)[0]))
    times, given = used.sensor(fastest)[0], dict(settings or {})
    if causal:
        lag, given = causal_lags(estimator, given, used, fastest)
    built = as_asked(create_estimator(estimator, model, **given), watch, smooth, on_lost)
    keeps = smooth or has_nees(model, used)
    keeps |= track is not None and len(used.time_s) <= most("smoothed_rows")
    steps = len(used.as_arrived(model)[0]) if causal else len(used.time_s)
    on_progress = on_start(steps) if on_start else None
    history = run(built, used, on_progress=on_progress, covariances=keeps, causal=causal)
    if causal:
        told = told_at(history, times, lag)
    else:
        lag = max(built.lags, default=0) if isinstance(built, LookingBack) else 0
        if lag >= len(history):
            raise InputError(
                f"a recording of {len(history)} instants has none that is followed by {lag}, "
                "expected more, or a shorter lag"
            )
        told = smoothed(model, used, history) if smooth else history.at_lag(lag)
    output = told.at(times[np.isin(times, told.time_s)] if lag or causal else times)
    return EstimateRun(
        model=model,
        used=used,
        history=history,
        output=output,
        left_out=left_out_error(model, cameras[0], told, recorded, used) if cameras else None,
        true_rms=true_rms(model, told, used),
        nis=nis_of(model, history),
        nees=nees_of(model, told, used),
        ink=ink_match(output, loaded.ink) if loaded.ink else None,
        zero_delay=() if causal else tuple(s.name for s in model.sensors if s.delay_s > 0),
        delays_s=delays_of(model, used),
        is_causal=causal,
        lag_samples=lag,
        rows_without=len(times) - len(output),
        is_smoothed=smooth,
        judged=None
        if track is None or truth is None
        else judged_by(track, model, output, offset_s=truth.offset_s, frame=truth.frame),
        notes=(*loaded.notes, *of_rest),
        findings=loaded.checked(recording.select(measured), pen).findings,
    )


def estimate(
    recording: Recording | WrittenRecording | RecordingPath,
    pen: AnyPen | None = None,
    *,
    axis: AnyAxis | None = None,
    sensors: Sequence[str] | None = None,
    estimator: str | None = None,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
    thinning: CameraThinning | None = None,
    duration_s: float | None = None,
    on_start: Callable[[int], Callable[[int], None]] | None = None,
    writing_area: bool = True,
    rest: bool = True,
    smooth: bool = False,
    causal: bool = False,
    watch: bool | None = None,
    on_lost: str | None = None,
    truth: TruthSource | None = None,
    truth_offset_s: float | None = None,
    truth_frame: str | None = None,
    truth_columns: ColumnsAsked | None = None,
    truth_units: Mapping[str, str] | None = None,
    **settings: Any,
) -> EstimateRun:
    """Estimate a recording in one call, and judge it by whatever reference it brings.

    The whole run is kept; ``pen-mhe estimate`` takes tables that are longer than memory.

    Parameters
    ----------
    recording : a recording, with the ink it left or without, or the path of a D-POINT folder,
        a table of any logger, or several of one recording
    pen : a pen, the name of a bundled one, or the path of a pen file; None takes what the
        recording shows, see `pen_mhe.no_pen.which.pen_of`
    axis : without a pen, see `pen_mhe.no_pen.pen_for.pen_for`
    sensors : names from the pen file; None takes all that the recording has
    estimator : one of `pen_mhe.estimators.ESTIMATORS`; None takes the usual one
    units, columns, strict : of a file, see `recordings.read.read_written`
    thinning, duration_s, on_start : see `estimate_recording`; `estimation.progress` draws a bar
    writing_area, rest, smooth, causal, watch, on_lost : see `estimate_recording`
    truth : motion capture, a tablet or angles, a file or `Truth`, with which the estimate is
        compared; clock and frame are aligned, see `pen_mhe.truth.align.aligned`
    truth_offset_s, truth_frame : added to its times, and ``same``, where nothing is to be aligned
    truth_columns, truth_units : of its file, ``"position=a,b,c;time=t"``; see
        `recordings.truths.asked.QUANTITIES`
    settings : of the estimator, see `pen_mhe.estimators.create_estimator`

    Raises
    ------
    InputError
        If something does not exist, does not fit together, or is not known by its name.
    """
    is_read = isinstance(recording, Recording | WrittenRecording)
    if is_read and (units or columns):
        what = "units" if units else "columns"
        raise InputError(f"{what} are given for a recording, expected none: its are SI")
    asked: dict[str, Any] = {"units": units, "columns": columns, "strict": strict}
    config, loaded = pen_and_recording(recording, pen, axis=axis, **asked)
    return estimate_recording(
        loaded,
        config,
        estimator=estimator or usual_estimator(pen),
        settings=settings,
        sensors=sensors,
        thinning=thinning,
        duration_s=duration_s,
        on_start=on_start,
        writing_area=writing_area,
        rest=rest,
        smooth=smooth,
        causal=causal,
        watch=watch,
        on_lost=on_lost,
        truth=GivenTruth.of(
            truth,
            offset_s=truth_offset_s,
            frame=truth_frame,
            columns=truth_columns,
            units=truth_units,
        ),
    )
