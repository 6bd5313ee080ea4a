"""Simulated recordings: motion, readings, truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Literal, get_args

import numpy as np

from estimation.outputs import outputs_of
from estimation.recording import Recording, Truth
from models.arrays import Array
from models.errors import InputError
from models.motions import MotionConfig, sample_motion
from models.names import expected_one_of, unknown
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen
from models.random_streams import seed_sequence, stream
from models.simulation import (
    arrival_times,
    drawn_states,
    sample_times,
    simulate_readings,
    true_states,
    union_of_times,
)
from models.state_space import StateSpaceModel
from recordings.input_signals import InputSignal, check_signals, sampled
from recordings.motion_list import DRAWN as DRAWN  # both are looked for here, too
from recordings.motion_list import motion_names as motion_names

Stamps = Literal["capture", "arrival"]


def sensors_with_a_rate(pen: PenConfig) -> tuple[str, ...]:
    """Return the names of a pen's sensors that can be simulated."""
    return tuple(name for name, sensor in pen.sensors.items() if sensor.rate_hz is not None)


def simulate(
    pen: AnyPen = "reference",
    sensors: Iterable[str] | None = None,
    *,
    motion: str | MotionConfig = "turn",
    duration_s: float = 3.0,
    seed: int = 0,
    speed: float = 1.0,
    stamps: Stamps | str = "capture",
) -> Recording:
    """Simulate a pen's sensors along a motion.

    One more sensor changes neither the motion nor another sensor's noise and biases;
    a motion drawn from the model stays only where the instants stay.

    Parameters
    ----------
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names of its sensors; None takes all that have a rate
    motion : a name of `motion_names`, or a configuration of one's own
    duration_s : s
    seed : of motion, biases, noise and losses; the same seed gives the same recording
    speed : plays the motion this many times faster
    stamps : ``capture`` stamps a reading with its true instant, ``arrival`` with the
        instant its sensor's delay later; the truth is given at both. When readings of a sensor
        with a delay arrive stands in ``arrivals`` either way

    Raises
    ------
    InputError
        If a name is unknown, a sensor has no rate, or a number makes no sense.
    """
    if isinstance(motion, str) and motion not in motion_names():
        raise unknown("motion", motion, motion_names())
    config = as_pen(pen)
    model = pen_model(config, sensors_with_a_rate(config) if sensors is None else sensors)
    if motion == DRAWN:
        if speed != 1:
            raise InputError(f"speed is {speed} for the motion {DRAWN}, expected 1: it has its own")
        return simulate_model(model, duration_s=duration_s, seed=seed, stamps=stamps)

    def truth(time_s: Array, captured: Mapping[str, Array], root: np.random.SeedSequence) -> Array:
        played = sample_motion(motion, time_s, seed=stream(root, "motion"), speed=speed)
        return true_states(model, played, root, times=captured)

    name = motion if isinstance(motion, str) else motion.kind
    return _record(name, model, truth, duration_s, seed, stamps)


def simulate_model(
    model: StateSpaceModel,
    *,
    duration_s: float = 3.0,
    seed: int = 0,
    stamps: Stamps | str = "capture",
    inputs: Mapping[str, InputSignal] | None = None,
) -> Recording:
    """Simulate any model's sensors along a truth drawn from its own prior and process noise.

    Parameters and errors as for `simulate`.

    Parameters
    ----------
    inputs : of a model that has some, each a number or a function of times (n,) in s; they are
        known at every instant, and act as the model says
    """
    given = inputs or {}
    check_signals(model, given)

    def truth(time_s: Array, captured: Mapping[str, Array], root: np.random.SeedSequence) -> Array:
        u = sampled(model, given, time_s)
        return drawn_states(model, time_s, stream(root, "motion"), inputs=u)

    return _record(DRAWN, model, truth, duration_s, seed, stamps, given)


def _record(
    name: str,
    model: StateSpaceModel,
    truth: Callable[[Array, Mapping[str, Array], np.random.SeedSequence], Array],
    duration_s: float,
    seed: int,
    stamps: Stamps | str,
    inputs: Mapping[str, InputSignal] | None = None,
) -> Recording:
    if stamps not in get_args(Stamps):
        raise InputError(f"stamps is {stamps}, {expected_one_of(stamps, get_args(Stamps))}")
    captured = sample_times(model, duration_s)
    arrived = arrival_times(model, captured)
    stamped = arrived if stamps == "arrival" else captured
    time_s, root = union_of_times(captured, stamped), seed_sequence(seed)
    states = truth(time_s, captured, root)
    outputs = outputs_of(model)
    more = [name for name in outputs.names if name not in model.state_names]
    columns = [outputs.names.index(name) for name in more]
    values = np.hstack([states, outputs.function(states.T).full().T[:, columns]])
    u = sampled(model, inputs or {}, time_s)
    readings = simulate_readings(model, captured, time_s, states, root, inputs=u).sensors
    return Recording.from_sensors(
        f"{name} (simulated)",
        {key: (stamped[key], values) for key, (_, values) in readings.items()},
        truth=Truth(time_s, (*model.state_names, *more), values),
        inputs={key: (time_s, u[:, i]) for i, key in enumerate(model.input_names)},
        arrivals={key: at for key, at in arrived.items() if model.sensor(key).delay_s > 0},
    )
