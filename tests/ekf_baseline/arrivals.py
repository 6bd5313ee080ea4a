"""Streams whose measurements arrive late and out of order, and what puts them in order."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.recording import Measurement
from models.arrays import Array
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from tests.estimation import pens
from tests.estimation.lamps import lamp, swung
from tests.estimation.resting import columns, inertial, instants, model_at_rest
from tests.linear_models import coupled_system, irregular_times

FAR = EkfConfig(late_samples=40)


@dataclass(frozen=True, eq=False)
class Stream:
    """A model, measurements in order of capture, and a filter's settings."""

    model: StateSpaceModel
    measurements: Sequence[Measurement]
    config: EkfConfig


def columns_of(model: StateSpaceModel) -> list[slice]:
    """Return the columns of each sensor's readings."""
    return [columns(model, sensor.name) for sensor in model.sensors]


def out_of_order(stream: Stream, seed: int, late_s: float) -> list[Measurement]:
    """Return measurements as they arrive: every sensor's apart, each by a delay of its own.

    Half of them are on time. Inputs are missing in some; the first, which tells them, is on time.
    """
    rng, model, parts = np.random.default_rng(seed), stream.model, []
    for k, measurement in enumerate(stream.measurements):
        for own in columns_of(model):
            y = np.full(model.n_row, np.nan)
            y[own] = measurement.y[own]
            if k == 0 or rng.uniform() < 0.7:
                y[model.n_y :] = measurement.y[model.n_y :]
            if np.isnan(y).all():
                continue
            delay_s = late_s * max(rng.uniform(-1, 1), 0)
            arrival = measurement.time_s + (0 if k == 0 and model.n_u else delay_s)
            parts.append((arrival, measurement.time_s, Measurement(measurement.time_s, y)))
    return [part for *_, part in sorted(parts, key=lambda part: part[:2])]


def in_order(model: StateSpaceModel, arrived: Sequence[Measurement]) -> list[Measurement]:
    """Return what has arrived in order of capture, late readings joined to a row of their stamp."""
    rows: list[Measurement] = []
    for new in arrived:
        place = sum(row.time_s <= new.time_s for row in rows)
        is_late = place < len(rows)
        alike = [k for k, row in enumerate(rows) if row.time_s == new.time_s and is_late]
        for k in reversed(alike):
            both = np.isfinite(rows[k].y) & np.isfinite(new.y)
            readings, inputs = both[: model.n_y], (both & (rows[k].y != new.y))[model.n_y :]
            if not readings.any() and not inputs.any():
                joined = np.where(np.isnan(rows[k].y), new.y, rows[k].y)
                rows[k] = replace(rows[k], y=joined)
                break
        else:
            rows.insert(place, new)
    return rows


def stacked(measurements: Sequence[Measurement]) -> tuple[Array, Array]:
    """Return times (n,) and rows (n, n_row)."""
    return np.array([m.time_s for m in measurements]), np.array([m.y for m in measurements])


def ekf(stream: Stream) -> Ekf:
    """Return the filter of a stream."""
    return Ekf(stream.model, stream.config)


def _pen(gate: float | None) -> Stream:
    run = pens.draw_pen_run(60, seed=11)
    measurements = list(run.measurements)
    wild = measurements[30].y.copy()
    wild[0] += 5.0
    measurements[30] = replace(measurements[30], y=wild)
    return Stream(run.model, measurements, EkfConfig(gate_probability=gate, late_samples=40))


def _linear() -> Stream:
    system, rng = coupled_system(3), np.random.default_rng(5)
    return Stream(system.model, system.simulate(irregular_times(60, rng), rng, 0.2), FAR)


def _at_rest() -> Stream:
    model, time_s = model_at_rest(), instants(1.6, 50.0)
    y = inertial(model, time_s, 1, bias_rad_s=0.01)
    rows = zip(time_s.tolist(), y, strict=True)
    return Stream(model, [Measurement(t, row) for t, row in rows], FAR)


def _lamp() -> Stream:
    model = lamp()
    return Stream(model, list(swung().measurements(model))[:60], FAR)


def _reference() -> Stream:
    sensors = ("accel", "gyro", "camera")
    recording = simulate("reference", sensors, motion="handwriting", duration_s=0.4, seed=1)
    model = pen_model(load_pen("reference"), sensors)
    return Stream(model, list(recording.measurements(model))[:60], FAR)


STREAMS: Mapping[str, Callable[[], Stream]] = {
    "pen": functools.cache(lambda: _pen(None)),
    "pen with a gate": functools.cache(lambda: _pen(0.999)),
    "linear": functools.cache(_linear),
    "at rest": functools.cache(_at_rest),
    "inputs": functools.cache(_lamp),
    "reference pen": functools.cache(_reference),
}
