"""Which subsets of a pen's sensors make sense, derived from what their kinds read."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain, product

from benchmark.configurations import SensorConfiguration
from models.errors import InputError
from models.pen_config import PenConfig


def choices(pen: PenConfig, among: Iterable[str]) -> list[SensorConfiguration]:
    """Return every choice of sensors that observes something, those without a camera first.

    Sensors of one kind are taken in the file's order: the first, the first two, and so on.
    Those that only add to others (contacts) are no choice alone: they stand beside all the others,
    without a camera and with it. What has no readings of its own (a writing area, rest that is
    detected) is none at all: `models.pen.pen_model` adds it.

    Parameters
    ----------
    among : names of the sensors that have readings

    Raises
    ------
    InputError
        If none of them observes anything.
    """
    by_kind: dict[str, list[str]] = {}
    adding: list[str] = []
    for name in pen.sensors:
        sensor = pen.sensors[name]
        if name not in set(among) or sensor.place_m is not None or sensor.is_rest:
            continue
        if _observes(pen, name):
            by_kind.setdefault(sensor.kind, []).append(name)
        else:
            adding.append(name)
    ordered = [[names[:n] for n in range(len(names) + 1)] for names in by_kind.values()]
    found = [list(chain(*parts)) for parts in product(*ordered) if any(parts)]
    if not found:
        raise InputError(
            f"pen {pen.name} has no sensor with readings that observes its motion, expected an "
            "accelerometer, a gyroscope or a camera"
        )
    if adding:
        for has_camera in (False, True):
            alike = [names for names in found if _sees_pose(pen, names) == has_camera]
            found += [[*max(alike, key=len), *adding]] if alike else []
    place = list(pen.sensors).index
    rows = [
        SensorConfiguration("+".join(names), tuple(names), _sees_pose(pen, names))
        for names in found
    ]
    return sorted(
        rows, key=lambda row: (row.needs_camera, len(row.sensors), [*map(place, row.sensors)])
    )


def _sees_pose(pen: PenConfig, names: Iterable[str]) -> bool:
    return any(pen.sensors[name].sees_pose for name in names)


def _observes(pen: PenConfig, name: str) -> bool:
    sensor = pen.sensors[name]
    return sensor.feels_gravity or sensor.reads_rate or sensor.sees_pose
