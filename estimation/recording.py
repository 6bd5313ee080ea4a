"""What was measured, and when: time-stamped readings of named sensors."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from estimation.arrivals import given_arrivals, has_reading, merged_arrivals
from estimation.input_columns import given_inputs
from estimation.measurement import Measurement as Measurement  # many take both from here
from estimation.reading_columns import given_columns, given_readings, given_times
from estimation.stacking import check_sensors, in_order_of_arrival, in_order_of_capture
from estimation.truth import Truth as Truth
from models.arrays import Array
from models.errors import InputError
from models.frozen_mapping import FrozenMapping
from models.names import expected_one_of
from models.state_space import StateSpaceModel
from models.units import TIME_DIGITS


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Readings of sensors on one time axis, the union of all their stamps.

    Parameters
    ----------
    name : for people
    time_s : (n,) strictly increasing, s; lists and pandas objects are taken as well
    readings : sensor name → (n, n_y) in SI, or (n,) of one axis, NaN where there is no reading
    truth : true states, where known; no estimator is given them
    inputs : name → (n,) known inputs of a model of one's own, in its unit, NaN where one is as it
        was before; a number stays
    arrivals : sensor name → (n,) when its readings arrive, s, NaN where there is none; a sensor
        without has its model's delay: capture + `delay_s`

    Raises
    ------
    InputError
        If it is empty, times do not increase, readings, inputs or arrivals have another shape
        or are infinite, or a reading arrives before its capture.
    """

    name: str
    time_s: Array
    readings: Mapping[str, Array]
    truth: Truth | None = None
    inputs: Mapping[str, Array] = field(default_factory=dict)
    arrivals: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        where = f"recording {self.name}"
        time_s = given_times(where, self.time_s)
        readings = given_readings(where, len(time_s), self.readings)
        inputs = given_inputs(where, time_s, self.inputs)
        arrivals = given_arrivals(where, time_s, readings, self.arrivals)
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "readings", FrozenMapping(readings))
        object.__setattr__(self, "inputs", FrozenMapping(inputs))
        object.__setattr__(self, "arrivals", FrozenMapping(arrivals))

    @classmethod
    def from_sensors(
        cls,
        name: str,
        sensors: Mapping[str, tuple[Array, Array]],
        *,
        truth: Truth | None = None,
        inputs: Mapping[str, tuple[Array, Array]] | None = None,
        arrivals: Mapping[str, Array] | None = None,
    ) -> Recording:
        """Merge sensors with time stamps of their own; no reading moves in time.

        Parameters
        ----------
        sensors : name → (times (n,) s, values (n, n_y) SI)
        inputs : name → (times (n,) s, values (n,)) of known inputs, held until the next time
        arrivals : sensor name → (n,) when each of its readings arrives, s

        Raises
        ------
        InputError
            If a sensor has two readings, or an input two values, at one time, or not as many
            arrivals as readings.
        """
        given = given_columns(f"recording {name}", inputs or {})
        both = [key for key in given if key in sensors]
        if both:
            raise InputError(
                f"recording {name}: {both[0]} is a sensor and an input, expected two names"
            )
        sensors = {**given_columns(f"recording {name}", sensors), **given}
        stamps = {sensor: np.round(times, TIME_DIGITS) for sensor, (times, _) in sensors.items()}
        time_s = np.unique(np.concatenate([np.zeros(0), *stamps.values()]))
        readings = {}
        for sensor, (_, values) in sensors.items():
            times = stamps[sensor]
            unique, counts = np.unique(times, return_counts=True)
            if (counts > 1).any():
                raise InputError(
                    f"recording {name}: {sensor} has two readings at "
                    f"{unique[counts > 1][0]:g} s, expected one"
                )
            merged = np.full((len(time_s), values.shape[1]), np.nan)
            merged[np.searchsorted(time_s, times)] = values
            readings[sensor] = merged
        held = {name: readings.pop(name)[:, 0] for name in given}
        arrived = merged_arrivals(f"recording {name}", time_s, stamps, arrivals or {})
        return cls(name, time_s, readings, truth, held, arrived)

    def __repr__(self) -> str:
        counts = ", ".join(f"{name} {len(self.sensor(name)[0])}" for name in self.readings)
        inputs = f", inputs: {', '.join(self.inputs)}" if self.inputs else ""
        truth = "" if self.truth is None else f", truth of {len(self.truth.names)} states"
        return (
            f"<Recording {self.name}: {self.time_s[0]:g} s to {self.time_s[-1]:g} s, "
            f"readings: {counts}{inputs}{truth}>"
        )

    def sensor(self, name: str) -> tuple[Array, Array]:
        """Return (times, values) of one sensor where it has any reading.

        Raises
        ------
        InputError
            If there is no such sensor.
        """
        if name not in self.readings:
            raise InputError(
                f"recording {self.name} has no sensor {name}; "
                f"{expected_one_of(name, self.readings)}"
            )
        present = has_reading(self.readings[name])
        return self.time_s[present], self.readings[name][present]

    def select(self, sensors: Sequence[str]) -> Recording:
        """Return a recording of some sensors and all inputs, without instants left empty."""
        parts = {sensor: self.sensor(sensor) for sensor in sensors}
        return self._of(parts)

    def subsampled(self, sensor: str, every: int, phase: int) -> Recording:
        """Return a recording that keeps a sensor's readings number phase, phase + every, …"""
        parts = {name: self.sensor(name) for name in self.readings}
        times, values = self.sensor(sensor)
        parts[sensor] = (times[phase::every], values[phase::every])
        return self._of(parts)

    def _of(self, sensors: Mapping[str, tuple[Array, Array]]) -> Recording:
        """Return a recording of some of the readings, with all else of this one."""
        given = {name: ~np.isnan(values) for name, values in self.inputs.items()}
        inputs = {name: (self.time_s[at], self.inputs[name][at]) for name, at in given.items()}
        arrivals = {
            name: self.arrivals[name][np.searchsorted(self.time_s, times)]
            for name, (times, _) in sensors.items()
            if name in self.arrivals
        }
        return self.from_sensors(
            self.name, sensors, truth=self.truth, inputs=inputs, arrivals=arrivals
        )

    def first(self, duration_s: float) -> Recording:
        """Return the first `duration_s` seconds."""
        return self.some_rows(self.time_s <= self.time_s[0] + duration_s)

    def some_rows(self, rows: np.ndarray) -> Recording:
        """Return some of the instants (n,), at least one, with the whole truth."""
        return dataclasses.replace(
            self,
            time_s=self.time_s[rows],
            readings={name: values[rows] for name, values in self.readings.items()},
            inputs={name: values[rows] for name, values in self.inputs.items()},
            arrivals={name: values[rows] for name, values in self.arrivals.items()},
        )

    def stacked(self, model: StateSpaceModel) -> tuple[Array, Array]:
        """Return what the model's sensors measured, all instants at once.

        A sensor with a constant reading of its own (the writing area) speaks at
        the first instant of each of its periods. Rest, which estimators find themselves, has
        the readings that it has here, or none.

        Returns
        -------
        times (n,) in s, stacked readings y (n, n_row) in the model's order and units, NaN
        where there is none; behind them the model's inputs, held where they are missing

        Raises
        ------
        InputError
            If the recording lacks one of the model's sensors or inputs, a sensor has another
            number of columns, an input is not known from the first instant on, or instants are
            no whole number of the model's intervals apart.
        """
        check_sensors(self, model)
        return in_order_of_capture(self, model)

    def as_arrived(self, model: StateSpaceModel) -> tuple[Array, Array, Array]:
        """Return what the model's sensors measured in the order in which it arrived.

        A row per capture and arrival, those of one arrival by capture; none where nothing
        arrives. Inputs arrive at their instant; rows of late readings have none (NaN), nor a
        constant reading.

        Returns
        -------
        times of capture (n,) in s, which may go back, rows (n, n_row) as of `stacked`, and
        arrivals (n,) in s, ascending

        Raises
        ------
        InputError
            As for `stacked`, or if none of the model's sensors has any reading.
        """
        check_sensors(self, model)
        return in_order_of_arrival(self, model)

    def measurements(
        self, model: StateSpaceModel, *, causal: bool = False
    ) -> Iterator[Measurement]:
        """Yield the rows of `stacked`, instant by instant; causal ones as of `as_arrived`."""
        if causal:
            for time_s, y, arrival_s in zip(*self.as_arrived(model), strict=True):
                yield Measurement(float(time_s), y, float(arrival_s))
        else:
            for time_s, y in zip(*self.stacked(model), strict=True):
                yield Measurement(float(time_s), y)
