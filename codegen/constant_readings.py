"""Sensors that nobody reads: the exported step adds the readings of those that read a constant (a
pen's writing area), and its loop those of rest, which it detects.
"""

from __future__ import annotations

from dataclasses import dataclass

from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel


@dataclass(frozen=True)
class StackedSensor:
    """A sensor and the place of its first reading among all."""

    sensor: SensorModel
    column: int


def stacked_sensors(model: StateSpaceModel) -> list[StackedSensor]:
    """Return all sensors of a model with their places."""
    found, column = [], 0
    for sensor in model.sensors:
        found.append(StackedSensor(sensor, column))
        column += sensor.n_y
    return found


def measured_columns(model: StateSpaceModel) -> list[int]:
    """Return the places of what a caller gives: readings in their order, then known inputs."""
    readings = [
        stacked.column + i
        for stacked in stacked_sensors(model)
        if stacked.sensor.has_readings
        for i in range(stacked.sensor.n_y)
    ]
    return [*readings, *range(model.n_y, model.n_row)]


def given_names(model: StateSpaceModel) -> list[str]:
    """Return the names of `measured_columns`."""
    names = (*model.reading_names, *model.input_names)
    return [names[i] for i in measured_columns(model)]


def detected_sensors(model: StateSpaceModel) -> list[StackedSensor]:
    """Return the sensors whose readings the loop makes of those of others."""
    return [s for s in stacked_sensors(model) if s.sensor.rest is not None]


def constant_sensors(model: StateSpaceModel) -> list[StackedSensor]:
    """Return the sensors whose readings the step adds."""
    return [s for s in stacked_sensors(model) if s.sensor.constant_reading is not None]
