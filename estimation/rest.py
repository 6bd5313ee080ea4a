"""Whether a body rests: found from the inertial readings of the last second, causally.

It rests while over the window of `models.sensor_model.RestRule`

- every axis of every accelerometer and gyroscope spreads by less than `spread_factor` of its
  noise, and the newest reading is within twice that of the mean,
- the means of both halves of the window differ by less than the noise and less than chance
  would have it (`HALVES` standard errors),
- the mean rate of every gyroscope, as a vector, is below what its bias can be, and no farther
  from that of the last rest than its bias has walked since: what differs is a slow turn, unless
  it stays for `PATIENCE` windows.

A gap, a reading at its sensor's limit, or a reading that never changes where its noise should
show ends rest, or keeps it from beginning. The window is kept as `BLOCKS` blocks of (number, mean,
sum of squared deviations) per axis (Chan, Golub and LeVeque 1983), so memory depends on no rate
and single precision is enough. The detector itself: `estimation.rest_detector`, and in C rest.c.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.arrays import Array
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

BLOCKS = 8
"""Closed blocks of a window; one more is being filled."""
FEWEST = 4
"""Readings that each half of a window must have of each axis."""
GAP = 0.25
"""Part of the window without an inertial reading after which it begins anew."""
HALVES = 5.0
"""Standard errors by which the means of two halves may differ: six axes at 100 Hz then hide rest
once in hours."""
NEWEST = 2.0
"""Spreads that the newest reading may be off the mean."""
LARGEST_BIAS = 4.0
"""Standard deviations of a gyroscope's bias that its mean rate may have beyond the known bias. One
pen in 900 has a larger bias and never rests; with 3, one in 34 had. A turn slower than this is
taken for bias."""
WALKED = 4.0
"""Standard deviations that a bias may have walked since the last rest."""
PATIENCE = 60.0
"""Windows after which a rate that differs from the last rest's is bias after all: no hand turns a
pen so evenly for so long, and a bias that a knock has moved is not lost for ever."""
ROUNDING = 1e-3
"""Part of a block's length within which it is full."""
CONSTANTS: Mapping[str, float] = {
    "REST_BLOCKS": BLOCKS,
    "REST_FEWEST": FEWEST,
    "REST_HALVES": HALVES,
    "REST_NEWEST": NEWEST,
}
"""Macros of rest.c."""


@dataclass(frozen=True, eq=False)
class RestAxes:
    """The inertial axes of a model, and where the reading of rest goes.

    Parameters
    ----------
    column : (n,) place of each axis among the readings
    noise_std : (n,) in the reading's unit
    may_repeat : (n,) whether a resting axis may read the same all the time: where the
        quantiser's step is larger than twice the noise
    gyroscope : (n,) number of the gyroscope it belongs to, -1 for accelerometers
    walk_square : (n,) growth of the square of what its bias may have walked, 0 for accelerometers
    largest_square : (n_gyroscopes,) square of the largest bias, rad²/s²
    first, count : columns of the sensor of rest
    """

    column: NDArray[np.int64]
    noise_std: Array
    may_repeat: NDArray[np.bool_]
    gyroscope: NDArray[np.int64]
    walk_square: Array
    largest_square: Array
    first: int
    count: int


def detected_rest(model: StateSpaceModel) -> SensorModel | None:
    """Return the sensor whose readings are found here; None where the model has none."""
    return next((sensor for sensor in model.sensors if sensor.rest is not None), None)


def rest_axes(model: StateSpaceModel) -> RestAxes:
    """Return the tables of a model that has such a sensor."""
    sensor_of_rest = detected_rest(model)
    assert sensor_of_rest is not None
    assert sensor_of_rest.rest is not None
    told = sensor_of_rest.rest.largest_bias_rad_s
    column: list[int] = []
    noise: list[float] = []
    may_repeat: list[bool] = []
    gyroscope: list[int] = []
    walk: list[float] = []
    largest: list[float] = []
    first = start = 0
    for sensor in model.sensors:
        if sensor is sensor_of_rest:
            first = start
        if sensor.feels_gravity or sensor.reads_rate:
            column += range(start, start + sensor.n_y)
            noise += sensor.noise_std.tolist()
            may_repeat += (sensor.drawn_std < sensor.resolution / 2).tolist()
            gyroscope += [len(largest) if sensor.reads_rate else -1] * sensor.n_y
            walk += [(WALKED * sensor.bias_walk) ** 2 * sensor.reads_rate] * sensor.n_y
        if sensor.reads_rate:
            largest.append(_largest_bias(model, sensor, told))
        start += sensor.n_y
    return RestAxes(
        np.array(column, dtype=np.int64),
        np.array(noise, dtype=float),
        np.array(may_repeat, dtype=bool),
        np.array(gyroscope, dtype=np.int64),
        np.array(walk, dtype=float),
        np.square(np.array(largest, dtype=float)),
        first,
        sensor_of_rest.n_y,
    )


def _largest_bias(model: StateSpaceModel, sensor: SensorModel, told: float | None) -> float:
    """Return the largest mean rate of a gyroscope that may be bias, rad/s."""
    if told is not None:
        return told
    states = [model.state_names.index(name) for name in sensor.bias_states]
    known = float(np.linalg.norm(model.prior.mean[states]))
    return known + LARGEST_BIAS * max(model.prior.std[states], default=0.0)


def rest_blocks(model: StateSpaceModel) -> Mapping[str, tuple[int, ...]]:
    """Return the blocks that an estimator's state has for the detector; none without one.

    All zero before the first measurement. ``rest_told`` is 1 once a reading of rest was given
    from outside, ``rest_closed`` how many blocks are full, ``rest_since`` the time since the last
    inertial reading, ``rest_age`` how long each block is; ``rest_known`` 1 once there was rest,
    ``rest_ago`` the time since, ``rest_bias`` the means then, ``rest_waits`` for how long another
    mean has been refused.
    """
    if detected_rest(model) is None:
        return {}
    n = len(rest_axes(model).column)
    return {
        **dict.fromkeys(("rest_told", "rest_known", "rest_ago", "rest_waits"), ()),
        "rest_bias": (n,),
        **dict.fromkeys(("rest_closed", "rest_since"), ()),
        "rest_age": (BLOCKS + 1,),
        **dict.fromkeys(("rest_n", "rest_mean", "rest_square"), (BLOCKS + 1, n)),
    }


def rest_fields(model: StateSpaceModel) -> dict[str, Any]:
    """Return the C structure Rest of estimation/rest.c, for a loop's fields; {} without rest."""
    sensor = detected_rest(model)
    if sensor is None or sensor.rest is None:
        return {}
    axes = rest_axes(model)
    n = len(axes.column)
    return {
        "rest": {
            "n": n,
            "n_gyroscopes": len(axes.largest_square),
            "column": axes.column,
            "noise_std": axes.noise_std,
            "may_repeat": axes.may_repeat,
            "gyroscope": axes.gyroscope,
            "walk_square": axes.walk_square,
            "largest_square": axes.largest_square,
            "first": axes.first,
            "count": axes.count,
            "spread_factor": float(sensor.rest.spread_factor),
            "block_s": float(block_s(sensor.rest.window_s)),
            "gap_s": float(GAP * sensor.rest.window_s),
            "patience_s": float(PATIENCE * sensor.rest.window_s),
            **{name: np.zeros(n) for name in ("number", "mean")},
            "turn": np.zeros(len(axes.largest_square)),
            "apart": np.zeros(len(axes.largest_square)),
            "y": np.zeros(model.n_row),
        }
    }


def rest_constants(model: StateSpaceModel) -> dict[str, float]:
    """Return the macros of estimation/rest.c; RESTS leaves it out where there is none."""
    if detected_rest(model) is None:
        return {"RESTS": 0}
    return {"RESTS": 1, **CONSTANTS}


def block_s(window_s: float) -> float:
    """Return how long a block is when it is full, s."""
    return window_s / BLOCKS * (1 - ROUNDING)
