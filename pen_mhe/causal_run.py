"""What a causal run needs: lags in samples of one sensor, its rows as told first, the delays.

An estimator's lag counts stages of its window, of all sensors that have arrived.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from estimation.arrivals import arrival_of, has_reading
from estimation.estimate import EstimateHistory
from estimation.estimator import LookingBack
from estimation.recording import Recording
from estimation.settings import config_of
from models.arrays import Array
from models.errors import InputError
from models.state_space import StateSpaceModel
from pen_mhe.estimators import ESTIMATORS, check_estimator, configs


def causal_lags(
    estimator: str, settings: Mapping[str, Any], used: Recording, sensor: str
) -> tuple[int, dict[str, Any]]:
    """Return the lag that is asked for, and settings with all lags of a window that it may be.

    So many samples of a sensor are as many stages of a window, and one more for each instant of
    another sensor between them that has arrived by then.

    Parameters
    ----------
    settings : of the estimator; of several `lag_samples` the largest is meant
    sensor : whose samples count

    Raises
    ------
    InputError
        If no estimator has the name, its settings are not allowed, the sensor has no more samples
        than the lag, or the window does not reach that far.
    """
    lag = largest_lag(estimator, settings)
    if lag == 0:
        return 0, dict(settings)
    times = used.sensor(sensor)[0]
    check_followed(lag, len(times), sensor)
    rows = np.searchsorted(used.time_s, times)
    most = int((rows[lag:] - rows[:-lag]).max())
    return lag, with_lags(settings, lag, most, sensor)


def largest_lag(estimator: str, settings: Mapping[str, Any]) -> int:
    """Return the largest lag of an estimator's settings, 0 where it tells of no earlier instant.

    Raises
    ------
    InputError
        If no estimator has the name, or its settings are not allowed.
    """
    check_estimator(estimator)
    config = config_of(estimator, configs(), {**ESTIMATORS[estimator].defaults, **settings})
    return max(config.lags, default=0) if isinstance(config, LookingBack) else 0


def check_followed(lag: int, samples: int, sensor: str) -> None:
    """Raise `InputError` unless a sensor has more samples than a lag."""
    if lag >= samples:
        raise InputError(
            f"a recording of {samples} samples of {sensor} has none that is followed by {lag}, "
            "expected more, or a shorter lag"
        )


def with_lags(settings: Mapping[str, Any], lag: int, most: int, sensor: str) -> dict[str, Any]:
    """Return settings with all lags of a window that a lag in samples of a sensor may be.

    Parameters
    ----------
    most : instants of all sensors that so many samples are at most

    Raises
    ------
    InputError
        If the window does not reach that far.
    """
    if most > settings.get("horizon", most):
        raise InputError(
            f"{lag} samples of {sensor} are up to {most} instants of all sensors, expected a "
            f"horizon of at least {most}"
        )
    return {**settings, "lag_samples": tuple(range(lag, most + 1))}


def told_at(history: EstimateHistory, times: np.ndarray, lag: int) -> EstimateHistory:
    """Return what a causal run says of a sensor's instants (n,), each `lag` of them later.

    Instants that were older than another sensor's when they arrived have no row.

    Raises
    ------
    InputError
        If that leaves none.
    """
    newest = times[np.isin(times, history.time_s)]
    check_newest(lag, len(newest), len(times))
    return history.at_lag_of(lag, newest)


def check_newest(lag: int, newest: int, samples: int) -> None:
    """Raise `InputError` unless more samples than a lag were the newest when they arrived."""
    if newest <= lag:
        raise InputError(
            f"{newest} of {samples} samples were the newest when they arrived, expected "
            f"more than {lag}: the fastest sensor is later than others"
        )


def delays_of(model: StateSpaceModel, used: Recording) -> dict[str, float]:
    """Return, of each sensor that is late, by how much: the median from capture to arrival."""
    found = {name: float(np.median(late)) for name, late in lateness(model, used).items()}
    return {name: delay_s for name, delay_s in found.items() if delay_s > 0}


def lateness(model: StateSpaceModel, used: Recording) -> dict[str, Array]:
    """Return by sensor from capture to arrival (n,) of each of its readings, s."""
    return {
        sensor.name: (arrival_of(used.time_s, used.arrivals, sensor) - used.time_s)[
            has_reading(used.readings[sensor.name])
        ]
        for sensor in model.sensors
        if sensor.name in used.readings
    }
