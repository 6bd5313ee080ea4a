"""How a recording is run through in parts, at its capture or as it arrives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from estimation.orders import InOrderOfArrival, InOrderOfCapture
from models.errors import InputError
from models.state_space import StateSpaceModel
from pen_mhe.causal_run import check_followed, check_newest, largest_lag, with_lags
from pen_mhe.streaming.rows import Order
from pen_mhe.streaming.survey import Survey, surveyed_arrivals
from pen_mhe.streaming.telling import AsArrived, InCaptureOrder, Telling
from recordings.formats.table_stream import TableStream
from recordings.parts import UsedParts


@dataclass(frozen=True)
class Plan:
    """How a recording is run through.

    Parameters
    ----------
    settings : of the estimator
    lag : in samples
    steps : how many there will be
    order, telling : of the rows, and of what is told
    tells_arrival : whether a row of the output is told later than the instant it speaks of
    """

    settings: Mapping[str, Any]
    lag: int
    steps: int
    order: Order
    telling: Telling
    tells_arrival: bool


def planned_at_capture(
    survey: Survey, model: StateSpaceModel, estimator: str, settings: Mapping[str, Any]
) -> Plan:
    """Return the plan of a run that takes readings at their capture.

    Raises
    ------
    InputError
        If the recording is shorter than the lag.
    """
    lag = largest_lag(estimator, settings)
    if lag >= survey.instants:
        raise InputError(
            f"a recording of {survey.instants} instants has none that is followed by {lag}, "
            "expected more, or a shorter lag"
        )
    order = InOrderOfCapture(model)
    return Plan(settings, lag, survey.instants, order, InCaptureOrder(lag), lag > 0)


def planned_as_arrived(
    survey: Survey,
    model: StateSpaceModel,
    estimator: str,
    settings: Mapping[str, Any],
    *,
    stream: TableStream,
    used: UsedParts,
    on_read: Callable[[float], None] | None = None,
) -> Plan:
    """Return the plan of a causal run; reads the recording once more.

    Raises
    ------
    InputError
        As `pen_mhe.causal_run.causal_lags` and `pen_mhe.causal_run.told_at`.
    """
    lag, fastest = largest_lag(estimator, settings), survey.fastest
    if lag:
        check_followed(lag, survey.samples, fastest)
    arrivals = surveyed_arrivals(stream, model, used, fastest=fastest, lag=lag, on_read=on_read)
    if lag:
        settings = with_lags(settings, lag, arrivals.most_instants, fastest)
    check_newest(lag, arrivals.newest, survey.samples)
    tells_arrival = lag > 0 or arrivals.is_late
    order = InOrderOfArrival(model)
    return Plan(settings, lag, arrivals.steps, order, AsArrived(lag), tells_arrival)
