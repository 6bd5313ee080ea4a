"""The sensors of a model that are watched, and how far their innovations are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from estimation.watch.limits import SensorLimits
from models.arrays import Array
from models.state_space import StateSpaceModel

Numbers = Sequence[float] | Array


@dataclass(frozen=True)
class Watchable:
    """A sensor that is watched.

    Parameters
    ----------
    index : among those of the model
    is_inertial : whether it feels how the body moves
    rows, columns : of the stacked residual and readings
    limits : see `estimation.watch.limits`
    """

    index: int
    is_inertial: bool
    rows: range
    columns: range
    limits: SensorLimits


def watchables(
    model: StateSpaceModel, limits: Sequence[SensorLimits | None]
) -> tuple[Watchable, ...]:
    """Return the sensors that have limits.

    Parameters
    ----------
    limits : one per sensor of the model; None for one that is not watched
    """
    found, row, column = list[Watchable](), 0, 0
    for index, (sensor, of_sensor) in enumerate(zip(model.sensors, limits, strict=True)):
        rows, columns = range(row, row + sensor.n_r), range(column, column + sensor.n_y)
        if of_sensor is not None:
            feels = sensor.feels_gravity or sensor.reads_rate
            found.append(Watchable(index, feels, rows, columns, of_sensor))
        row, column = rows.stop, columns.stop
    return tuple(found)


def distances(
    sensors: Sequence[Watchable], n_sensors: int, v: Numbers, S: Sequence[Numbers]
) -> tuple[list[float], list[float]]:
    """Return z and d² by its limit, see `estimation.watch.statistics.Statistics.distances`."""
    z, far = [math.nan] * len(v), [math.nan] * n_sensors
    for sensor in sensors:
        rows = [r for r in sensor.rows if not math.isnan(v[r])]
        if not rows:
            continue
        L, squared = list[list[float]](), 0.0
        for i, r in enumerate(rows):
            left, row = v[r], list[float]()
            for j in range(i):
                s = S[r][rows[j]]
                for k in range(j):
                    s -= row[k] * L[j][k]
                row.append(s / L[j][j])
            s = S[r][r]
            for k in range(i):
                s -= row[k] * row[k]
                left -= row[k] * z[rows[k]]
            row.append(math.sqrt(s) if s > 0 else math.nan)
            L.append(row)
            z[r] = left / row[i]
            squared += z[r] * z[r]
        far[sensor.index] = squared / sensor.limits.squared[len(rows) - 1]
    return z, far
