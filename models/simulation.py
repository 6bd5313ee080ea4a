"""Simulated readings: what the sensors of a model read along a known truth.

    y = clip(round_Δ(h(x) + v)),   v ~ N(0, σ²),   σ = density √(π/2 · bandwidth)

for inertial sensors; a camera's noise turns its residual, which is a rotation, and a
contact reads its own height while the tip touches; there is no reading where a sensor does not
see. The truth is a motion with biases that start from the prior's spread and walk as the model
says, or it is drawn from the model altogether. Every purpose has a stream of random numbers of its
own, `models.random_streams`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from models.arrays import Array, is_real
from models.errors import InputError
from models.motions import SampledMotion
from models.noisy_readings import digitised, noisy_readings, touching
from models.random_streams import Seed, seed_sequence, stream
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel
from models.true_path import true_path
from models.units import TIME_DIGITS

MOST_SAMPLES = 10_000_000
"""Of one sensor: more would not fit in memory."""


@dataclass(frozen=True, eq=False)
class SimulatedReadings:
    """Readings with the truth they came from.

    Parameters
    ----------
    sensors : name → (times of capture (n,), values (n, n_y), NaN where a sample was lost)
    time_s, states : (n,), (n, n_x): the true states at all instants
    """

    sensors: Mapping[str, tuple[Array, Array]]
    time_s: Array
    states: Array


def sample_times(model: StateSpaceModel, duration_s: float) -> dict[str, Array]:
    """Return each sensor's own sampling instants from 0 to the duration.

    Sensors without readings of their own (the writing area) have none.

    Raises
    ------
    InputError
        If a sensor has no rate, or the duration is not positive.
    """
    if not (is_real(duration_s) and 0 < duration_s < np.inf):
        raise InputError(f"duration is {duration_s!r} s, expected a positive time")
    times = {}
    for sensor in model.measured_sensors:
        if sensor.rate_hz is None:
            raise InputError(f"sensor {sensor.name} has no rate_hz, expected one to simulate it")
        count = int(np.floor(duration_s * sensor.rate_hz + 1e-9)) + 1
        if count > MOST_SAMPLES:
            raise InputError(
                f"duration is {duration_s:g} s: {count} samples of {sensor.name}, "
                f"expected at most {MOST_SAMPLES}"
            )
        times[sensor.name] = np.round(np.arange(count) / sensor.rate_hz, TIME_DIGITS)
    if not times:
        raise InputError("no sensor with readings to simulate, expected at least one")
    return times


def arrival_times(model: StateSpaceModel, times: Mapping[str, Array]) -> dict[str, Array]:
    """Return when the samples captured at given times arrive: each sensor's delay later."""
    return {
        name: np.round(captured + model.sensor(name).delay_s, TIME_DIGITS)
        for name, captured in times.items()
    }


def union_of_times(*times: Mapping[str, Array]) -> Array:
    """Return all instants at which any sensor samples (or its sample arrives)."""
    return np.unique(np.concatenate([at for each in times for at in each.values()]))


def drawn_states(
    model: StateSpaceModel,
    time_s: Array,
    rng: np.random.Generator,
    *,
    inputs: Array | None = None,
) -> Array:
    """Return states (n, n_x) drawn from any model: its prior, then its own noise.

        x₀ = retract(x̄, L ξ),  L Lᵀ = P̄;     x_{k+1} = f(x_k, w_k, Δt_k);     ξ, w ~ N(0, I)

    Every component of ξ and of w has a generator of its own, so states and noises that
    a model appends (one more bias) leave those before them as they were. Other instants
    are another draw.

    Parameters
    ----------
    time_s : (n,) increasing instants, s
    inputs : (n, n_u) known inputs at the instants, where the model has some
    """
    of_start, of_steps = rng.spawn(2)
    xi = np.array([g.standard_normal() for g in of_start.spawn(model.n_x)])
    n_w, n_steps = model.n_w, len(time_s) - 1
    w = np.array([g.standard_normal(n_steps) for g in of_steps.spawn(n_w)]).reshape(n_w, n_steps)
    L = np.linalg.cholesky(model.prior.covariance)
    states = np.zeros((len(time_s), model.n_x))
    states[0] = model.retract(model.prior.mean, L @ xi).full().ravel()
    for k, dt in enumerate(np.diff(time_s)):
        ends = () if inputs is None or not model.n_u else (inputs[k], inputs[k + 1])
        states[k + 1] = model.f(states[k], w[:, k], dt, *ends).full().ravel()
    return states


def true_states(
    model: StateSpaceModel,
    motion: SampledMotion,
    seed: Seed,
    *,
    times: Mapping[str, Array] | None = None,
) -> Array:
    """Return the states (n, n_x) of a pen along a motion, with biases as `states_along`.

    A pen of five degrees of freedom has no spin among its states: its sensors read with
    the pen's fixed spin, whatever the motion's.
    """
    return states_along(model, motion.time_s, true_path(motion), seed, times or {})


def states_along(
    model: StateSpaceModel,
    time_s: Array,
    path: Mapping[str, Array],
    seed: Seed,
    times: Mapping[str, Array],
) -> Array:
    """Return the states (n, n_x) of a model on a known path, sensor biases drawn.

    Parameters
    ----------
    time_s : (n,) increasing instants
    path : state name → (n,) its values; names that the model lacks do not matter
    times : sensor name → the instants that its bias walks by, each one of `time_s`.
        Further instants leave the walk at these as it is; `time_s` itself by default

    Raises
    ------
    InputError
        If a state is neither on the path nor the bias of a sensor.
    """
    root = seed_sequence(seed)
    columns = dict(path)
    for sensor in (sensor for sensor in model.sensors if sensor.bias_states):
        index = [model.state_names.index(name) for name in sensor.bias_states]
        walk = _bias_walk(
            sensor,
            model.prior.mean[index],
            model.prior.std[index],
            time_s,
            times.get(sensor.name, time_s),
            root,
        )
        columns.update(zip(sensor.bias_states, walk.T, strict=True))
    unknown = [name for name in model.state_names if name not in columns]
    if unknown:
        raise InputError(
            f"model {model.name}: the motion does not say what {unknown[0]} does, "
            f"expected a motion of {', '.join(path)}"
        )
    return np.column_stack([columns[name] for name in model.state_names])


def _bias_walk(
    sensor: SensorModel,
    mean: Array,
    std: Array,
    time_s: Array,
    own_s: Array,
    root: np.random.SeedSequence,
) -> Array:
    """Return the biases (n, n_b) of a sensor at all instants.

    At the sensor's own instants b_{k+1} = b_k + walk √Δt w. Between them goes a
    Brownian bridge: the chord, plus a second walk minus that walk's own chords.
    """

    def walk(purpose: str, at_s: Array) -> Array:
        w = stream(root, f"{purpose} of {sensor.name}").standard_normal((len(at_s), len(mean)))
        scale = sensor.bias_walk * np.sqrt(np.diff(at_s, prepend=at_s[0]))
        return np.cumsum(scale[:, None] * w, axis=0)

    start = stream(root, f"first bias of {sensor.name}").standard_normal(len(mean))
    at_own = mean + std * start + walk("bias", own_s)
    bridge = walk("bias between samples", time_s)
    own = np.searchsorted(time_s, own_s)
    chord = at_own - bridge[own]
    biases = bridge + np.column_stack([np.interp(time_s, own_s, column) for column in chord.T])
    biases[own] = at_own  # to the last digit, whatever the bridge
    return biases


def simulate_readings(
    model: StateSpaceModel,
    times: Mapping[str, Array],
    time_s: Array,
    states: Array,
    seed: Seed,
    *,
    inputs: Array | None = None,
) -> SimulatedReadings:
    """Read every sensor at its own instants: noise, quantiser, range, lost samples.

    Parameters
    ----------
    times : sensor name → its instants, each one of `time_s`
    time_s, states : (n,), (n, n_x) the truth
    seed : of the noise and of what gets lost
    inputs : (n, n_u) known inputs at the instants, where the model has some
    """
    root = seed_sequence(seed)
    sensors = {}
    for name, instants in times.items():
        sensor = model.sensor(name)
        rows = np.searchsorted(time_s, instants)
        if sensor.touched_height is not None:
            values = touching(sensor, states[rows])
        else:
            w = stream(root, f"noise of {name}").standard_normal((len(rows), sensor.n_r))
            u = None if inputs is None else inputs[rows]
            noisy = noisy_readings(sensor, states[rows], sensor.drawn_std * w, inputs=u)
            values = digitised(sensor, noisy)
        if sensor.seen is not None:
            values[sensor.seen(states[rows].T).full().ravel() < 0] = np.nan
        lost = stream(root, f"losses of {name}").random(len(rows)) < sensor.dropout_fraction
        values[lost] = np.nan
        sensors[name] = (instants, values)
    return SimulatedReadings(sensors, time_s, states)
