"""Simulated recordings of the turntable: both axes at their rates, or a stroke."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.random_streams import seed_sequence, stream
from models.simulation import sample_times, simulate_readings, states_along, union_of_times
from models.table_motion import TableMotion, sample_table_motion
from models.turntable import TurntableConfig, turntable_model

ROUNDING_RAD = 1e-9
"""By how much a run through the whole range of an axis may seem to leave it."""


def simulate_table(table: TurntableConfig, duration_s: float, seed: int) -> Recording:
    """Simulate all sensors of a table whose axes both run at their constant rates.

    The start is drawn so that the run stays within the ranges of the axes.

    Raises
    ------
    InputError
        If an axis has not the range for the duration.
    """
    rates = np.array([axis.rate_rad_s for axis in table.axes])
    first, last = np.array([axis.range_rad for axis in table.axes]).T
    spare = last - first - rates * duration_s
    if (spare < -ROUNDING_RAD).any():
        longest = float(((last - first) / rates).min())
        raise InputError(
            f"{table.name}: a run of {duration_s:g} s leaves the range of an axis, "
            f"expected at most {longest:.3g} s"
        )

    def both_run(time_s: Array, root: np.random.SeedSequence) -> Array:
        start = first + stream(root, "start").random(2) * np.maximum(spare, 0.0)
        return np.hstack([start + rates * time_s[:, None], np.tile(rates, (len(time_s), 1))])

    return _recorded(table, duration_s, seed, both_run)


def simulate_stroke(table: TurntableConfig, motion: TableMotion, seed: int) -> Recording:
    """Simulate all sensors of a table along a stroke.

    Raises
    ------
    InputError
        If the stroke may leave the range of an axis.
    """
    return _recorded(
        table,
        motion.duration_s,
        seed,
        lambda time_s, root: sample_table_motion(table, motion, time_s, stream(root, "rates")),
    )


def _recorded(
    table: TurntableConfig,
    duration_s: float,
    seed: int,
    path: Callable[[Array, np.random.SeedSequence], Array],
) -> Recording:
    """Record a path: instants (n,) → (φ, θ, φ̇, θ̇) (n, 4)."""
    model, root = turntable_model(table), seed_sequence(seed)
    times = sample_times(model, duration_s)
    time_s = union_of_times(times)
    columns = path(time_s, root).T
    named = dict(zip(model.state_names[: len(columns)], columns, strict=True))
    states = states_along(model, time_s, named, root, times)
    readings = simulate_readings(model, times, time_s, states, root)
    truth = Truth(time_s, model.state_names, states)
    return Recording.from_sensors(f"{table.name}, seed {seed}", readings.sensors, truth=truth)
