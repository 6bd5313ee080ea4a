"""A pen that moves from point to point for ever: its recording in as many parts as wanted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count, islice
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.output_file import whole_file
from estimation.outputs import outputs_of
from estimation.recording import Recording, Truth
from models.arrays import Array
from models.minimum_jerk import MinimumJerk
from models.motions import sample_motion
from models.noisy_readings import digitised
from models.pen import pen_model
from models.pen_config import PenConfig
from models.simulation import sample_times, union_of_times
from models.true_path import true_path
from models.units import TIME_DIGITS
from recordings.formats.table_writer import TableWriter
from recordings.formats.tables import recording_to_table

PART_S = 100.0
"""A whole number of every sensor's periods."""
HOME = np.array([0.0, 0.0, 0.0, -0.5, 0.9, 0.2])
"""Tip, m, and angles, rad, at which each part begins and ends."""
REACH = np.array([0.03, 0.03, 0.003, 0.3, 0.2, 0.3])
SHORTEST_S, LONGEST_S = 0.4, 1.2
"""Of the way from a point to the next."""


class EndlessPen:
    """Sensors of a pen on its way between random points, with biases that stay.

    Parameters
    ----------
    sensors : names of the pen's sensors
    seed : of motion, biases and noise
    """

    def __init__(self, pen: PenConfig, sensors: Sequence[str], *, seed: int = 0) -> None:
        self.model, self._seed = pen_model(pen, sensors), seed
        prior, rng = self.model.prior, np.random.default_rng(seed)
        at_start = prior.mean + prior.std * rng.standard_normal(len(prior.std))
        self._biases = dict(zip(self.model.state_names, at_start, strict=True))

    def parts(self) -> Iterator[Recording]:
        """Yield recordings of `PART_S` without end, each with its truth."""
        outputs = outputs_of(self.model)
        times = {
            name: at[at < PART_S - 1e-6] for name, at in sample_times(self.model, PART_S).items()
        }
        inside = union_of_times(times)
        more = [i for i, name in enumerate(outputs.names) if name not in self.model.state_names]
        names = (*self.model.state_names, *(outputs.names[i] for i in more))
        for part in count():
            rng, start_s = np.random.default_rng([self._seed, part]), part * PART_S
            states = self._states(inside, rng)
            values = np.hstack([states, outputs.function(states.T).full().T[:, more]])
            readings = {
                name: (
                    np.round(start_s + at, TIME_DIGITS),
                    self._read(name, states[np.searchsorted(inside, at)], rng),
                )
                for name, at in times.items()
            }
            truth = Truth(np.round(start_s + inside, TIME_DIGITS), names, values)
            yield Recording.from_sensors("endless", readings, truth=truth)

    def _states(self, time_s: Array, rng: np.random.Generator) -> Array:
        """Return the true states (n, n_x) at instants of a part."""
        steps = rng.uniform(SHORTEST_S, LONGEST_S, int(PART_S / SHORTEST_S))
        at = np.cumsum(steps)
        at = at[at < PART_S - SHORTEST_S]
        points = HOME + REACH * rng.uniform(-1, 1, (len(at), 6))
        knots = [HOME, *points, HOME]
        way = MinimumJerk(
            description="random points",
            time_s=(0.0, *at, PART_S),
            tip_m=[tuple(point[:3]) for point in knots],
            angles_rad=[tuple(point[3:]) for point in knots],
        )
        path = true_path(sample_motion(way, time_s))
        columns = [
            path[name] if name in path else np.full(len(time_s), self._biases[name])
            for name in self.model.state_names
        ]
        return np.column_stack(columns)

    def _read(self, name: str, states: Array, rng: np.random.Generator) -> Array:
        """Return noisy readings (n, n_y); a camera's noise turns about its target."""
        sensor = self.model.sensor(name)
        clean = sensor.h(states.T).full().T
        noise = sensor.drawn_std * rng.standard_normal((len(clean), sensor.n_r))
        noisy = clean + noise
        if sensor.sees_pose:
            turned = Rotation.from_rotvec(clean[:, 3:]) * Rotation.from_rotvec(noise[:, 3:])
            noisy[:, 3:] = turned.as_rotvec()
        return digitised(sensor, noisy)


def write_endless(path: Path, pen: PenConfig, sensors: Sequence[str], rows: int) -> None:
    """Write at least so many rows into a CSV or Parquet file, a part at a time."""
    parts = EndlessPen(pen, sensors).parts()
    first = next(parts)
    with whole_file(path) as file, TableWriter(file, path.suffix) as writer:
        writer.write(recording_to_table(first, pen))
        for part in islice(parts, -(-rows // len(first.time_s)) - 1):
            writer.write(recording_to_table(part, pen))
