"""A pen that moves along the same loop for ever: its recording in as many parts as wanted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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

LOOP_S = 4.0
"""A whole number of every sensor's periods."""
LOOPS_PER_PART = 25
LOOP = MinimumJerk(
    description="a loop on the paper, with a lift, that ends where it began",
    time_s=(0.0, 0.8, 1.6, 2.4, 3.2, 4.0),
    tip_m=(
        *((0.0, 0.0, 0.0), (0.03, 0.002, 0.0), (0.028, -0.03, 0.0)),
        *((0.0, -0.028, 0.004), (0.0, 0.01, 0.0), (0.0, 0.0, 0.0)),
    ),
    angles_rad=(
        *((-0.5, 0.9, 0.2), (-0.3, 1.0, 0.3), (-0.5, 0.8, 0.0)),
        *((-0.7, 0.9, 0.2), (-0.4, 1.0, 0.4), (-0.5, 0.9, 0.2)),
    ),
)


class EndlessPen:
    """Sensors of a pen along `LOOP`, again and again, with biases that stay.

    Parameters
    ----------
    sensors : names of the pen's sensors
    seed : of biases and noise
    """

    def __init__(self, pen: PenConfig, sensors: Sequence[str], *, seed: int = 0) -> None:
        self.model, self._seed = pen_model(pen, sensors), seed
        prior, rng = self.model.prior, np.random.default_rng(seed)
        at_start = prior.mean[: self.model.n_x] + prior.std * rng.standard_normal(len(prior.std))
        self._biases = dict(zip(self.model.state_names, at_start, strict=True))

    def states(self, time_s: Array) -> Array:
        """Return the true states (n, n_x) at instants."""
        phase = np.round(time_s % LOOP_S, TIME_DIGITS) % LOOP_S
        path = {**true_path(sample_motion(LOOP, phase))}
        columns = [
            path[name] if name in path else np.full(len(phase), self._biases[name])
            for name in self.model.state_names
        ]
        return np.column_stack(columns)

    def parts(self) -> Iterator[Recording]:
        """Yield recordings of `LOOPS_PER_PART` loops without end, each with its truth."""
        outputs, loop = outputs_of(self.model), _of_loop(sample_times(self.model, LOOP_S))
        inside = union_of_times(loop)
        states = self.states(inside)
        more = [i for i, name in enumerate(outputs.names) if name not in self.model.state_names]
        values = np.hstack([states, outputs.function(states.T).full().T[:, more]])
        names = (*self.model.state_names, *(outputs.names[i] for i in more))
        clean = {
            name: np.column_stack([np.asarray(self.model.sensor(name).h(x)) for x in rows]).T
            for name, times in loop.items()
            if len(rows := states[np.searchsorted(inside, times)])
        }
        starts = LOOP_S * np.arange(LOOPS_PER_PART)
        for part in count():
            rng = np.random.default_rng([self._seed, part])
            of_part = LOOPS_PER_PART * LOOP_S * part + starts
            yield Recording.from_sensors(
                "endless",
                {
                    name: (_repeated(of_part, times), self._read(name, clean[name], rng))
                    for name, times in loop.items()
                },
                truth=Truth(_repeated(of_part, inside), names, np.tile(values, (len(starts), 1))),
            )

    def _read(self, name: str, clean: Array, rng: np.random.Generator) -> Array:
        """Return noisy readings (n, n_y) of a part's loops; a camera's noise turns about it."""
        sensor, rows = self.model.sensor(name), np.tile(clean, (LOOPS_PER_PART, 1))
        noise = sensor.drawn_std * rng.standard_normal((len(rows), sensor.n_r))
        noisy = rows + noise
        if sensor.sees_pose:
            turned = Rotation.from_rotvec(rows[:, 3:]) * Rotation.from_rotvec(noise[:, 3:])
            noisy[:, 3:] = turned.as_rotvec()
        return digitised(sensor, noisy)


def _of_loop(times: Mapping[str, Array]) -> dict[str, Array]:
    """Return the instants of one loop, without those of the next."""
    return {name: at[at < LOOP_S - 1e-6] for name, at in times.items()}


def _repeated(starts: Array, times: Array) -> Array:
    return np.round(np.add.outer(starts, times).ravel(), TIME_DIGITS)


def write_endless(path: Path, pen: PenConfig, sensors: Sequence[str], rows: int) -> None:
    """Write at least so many rows into a CSV or Parquet file, a part at a time."""
    parts = EndlessPen(pen, sensors).parts()
    first = next(parts)
    with whole_file(path) as file, TableWriter(file, path.suffix) as writer:
        writer.write(recording_to_table(first, pen))
        for part in islice(parts, -(-rows // len(first.time_s)) - 1):
            writer.write(recording_to_table(part, pen))
