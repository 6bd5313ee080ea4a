"""What a check looks at: readings of inertial sensors, and what several checks need of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.pen_config import PenConfig
from models.sensor_kinds.inertial import InertialSensor
from recordings.checks.axes_fit import CANDIDATES, AxesFit, fit_axes
from recordings.checks.lever import Lever, lever_of
from recordings.checks.mountings import up_of
from recordings.checks.quiet import noise_at_rest
from recordings.checks.repeats import RepeatedReading, stuck_runs
from recordings.checks.turns import GravityTurns, gravity_turns

Signal = tuple[Array, Array]
"""Times (n,) and complete readings (n, k) of a sensor."""
ENOUGH_HZ = 150.0
"""For what a hand does; more readings are averaged."""
FEWEST_MEANS = 10
FEWEST_TURNS = 4
"""Windows in which gravity turned."""
LEAST_TURN_RAD = np.radians(1.5)


def fewer(time_s: Array, values: Array) -> Signal:
    """Return means of successive readings, as many as keep to `ENOUGH_HZ`."""
    steps = np.diff(time_s)
    k = max(1, int(1 / (ENOUGH_HZ * float(np.median(steps))))) if len(steps) else 1
    if len(time_s) < FEWEST_MEANS * k:
        return time_s, values
    n = len(time_s) // k * k
    return time_s[:n].reshape(-1, k).mean(axis=1), values[:n].reshape(-1, k, 3).mean(axis=1)


@dataclass(frozen=True, eq=False)
class Pair:
    """An accelerometer and a gyroscope of three axes each, in axes of the body.

    Parameters
    ----------
    force, rate : names of the sensors
    turns : how gravity turned, as the two have it
    fit : in which axes of the gyroscope; None where gravity did not turn
    """

    force: str
    rate: str
    turns: GravityTurns
    fit: AxesFit | None


class Looked:
    """A recording of a pen, as far as checks look at it.

    Parameters
    ----------
    recording : see `recordings.checks.sketch.Sketch`
    pen : whose sensors it has
    breaks_s : times after which rows were left out
    columns : sensor → its columns in the file, where they have names of their own
    """

    def __init__(
        self,
        recording: Recording,
        pen: PenConfig,
        breaks_s: Array,
        *,
        columns: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        self.recording, self.pen, self.breaks_s = recording, pen, breaks_s
        self._columns = columns or {}

    def columns_of(self, name: str) -> tuple[str, ...]:
        """Return the names of a sensor's columns in its file, axis by axis."""
        axes = [axis for axis, _ in self.pen.sensors[name].reading_axes]
        given = self._columns.get(name, ())
        return given if len(given) == len(axes) else tuple(f"{name}_{axis}" for axis in axes)

    @cached_property
    def inertial(self) -> dict[str, InertialSensor]:
        """Sensors that read force or rate, and have readings."""
        return {
            name: sensor
            for name, sensor in self.pen.sensors.items()
            if isinstance(sensor, InertialSensor) and len(self.raw.get(name, ((), ()))[0]) > 1
        }

    @cached_property
    def raw(self) -> dict[str, Signal]:
        """Complete readings of every sensor, in its own axes."""
        found = {}
        for name, values in self.recording.readings.items():
            whole = ~np.isnan(values).any(axis=1)
            found[name] = self.recording.time_s[whole], values[whole]
        return found

    @cached_property
    def stuck(self) -> dict[str, list[RepeatedReading]]:
        """Where inertial sensors repeat a reading."""
        return {
            name: stuck_runs(
                *self.raw[name],
                [self.raw[other] for other in self.inertial if other != name],
                limit=sensor.reading_limit,
            )
            for name, sensor in self.inertial.items()
        }

    @cached_property
    def signals(self) -> dict[str, Signal]:
        """Readings of inertial sensors where they are not stuck, without the bias that is known."""
        found = {}
        for name, sensor in self.inertial.items():
            time_s, values = self.raw[name]
            free = np.ones(len(time_s), dtype=bool)
            for run in self.stuck[name]:
                free[run.first + 1 : run.end] = False
            bias = [sensor.bias["xyz".index(axis)] for axis in sensor.axes]
            found[name] = time_s[free], values[free] - bias
        return found

    @cached_property
    def noise(self) -> dict[str, Array]:
        """Standard deviations (k,) of inertial sensors at rest; none without a rest."""
        return noise_at_rest(self.signals)

    def steps_of(self, name: str) -> Signal:
        """Return when (n,) steps of a sensor begin, and how long (n,) they are, without breaks."""
        time_s, _ = self.raw[name]
        steps = np.diff(time_s)
        left_out = np.searchsorted(time_s, self.breaks_s, side="right") - 1
        kept = np.ones(len(steps), dtype=bool)
        kept[left_out[(left_out >= 0) & (left_out < len(steps))]] = False
        return time_s[:-1][kept], steps[kept]

    @cached_property
    def forces(self) -> dict[str, Signal]:
        """Readings of accelerometers of three axes, along axes of the body."""
        return self._in_body("feels_gravity")

    @cached_property
    def rates(self) -> dict[str, Signal]:
        """Readings of gyroscopes of three axes, about axes of the body."""
        return self._in_body("reads_rate")

    def _in_body(self, what: str) -> dict[str, Signal]:
        found = {}
        for name, sensor in self.inertial.items():
            time_s, values = self.signals[name]
            if getattr(sensor, what) and len(sensor.axes) == 3 and len(time_s) > 1:
                order = ["xyz".index(axis) for axis in sensor.axes]
                mounted = np.array(sensor.sensor_to_body)[:, order]
                time_s, values = fewer(time_s, values)
                found[name] = time_s, values @ mounted.T
        return found

    @cached_property
    def pairs(self) -> list[Pair]:
        """Each accelerometer with each gyroscope."""
        found = []
        for force, one in self.forces.items():
            for rate, other in self.rates.items():
                turns = gravity_turns(*one, *other)
                has_turned = np.linalg.norm(turns.turned, axis=1) > LEAST_TURN_RAD
                fit = fit_axes(turns) if has_turned.sum() >= FEWEST_TURNS else None
                found.append(Pair(force, rate, turns, fit))
        return found

    @cached_property
    def ups(self) -> dict[str, Array]:
        """Which way accelerometers say is up, (3,) on the mean, in axes of the body."""
        found = {name: up_of(force) for name, (_, force) in self.forces.items()}
        return {name: up for name, up in found.items() if up is not None}

    @cached_property
    def levers(self) -> dict[str, Lever]:
        """Accelerometer → its place from the point that rests, in axes of the body.

        The gyroscope's axes are taken as they fit the accelerometer's.
        """
        found = {}
        for pair in self.pairs:
            if pair.fit is None or pair.force in found:
                continue
            best = pair.fit.best if pair.fit.worse_by(0, pair.fit.best) > 1 else 0
            time_s, rate = self.rates[pair.rate]
            turned = rate @ CANDIDATES[best].T + pair.fit.bias[best]
            force = self.forces[pair.force]
            told = np.array([self.inertial[pair.force].sample_std])
            of_one = self.noise.get(pair.force, told) ** 2
            fewer_by = len(self.signals[pair.force][0]) // len(force[0])
            noise = float(np.sqrt(of_one.mean() / fewer_by))
            lever = lever_of(*force, time_s, turned, noise_std=noise)
            if lever is not None:
                found[pair.force] = lever
        return found
