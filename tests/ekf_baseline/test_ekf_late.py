"""Late measurements: the filter says, to the last bit, what it would have said in order."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig, EkfState
from ekf_baseline.state import FEWEST, default_reach
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from models.errors import InputError
from tests.ekf_baseline.arrivals import STREAMS, Stream, ekf, in_order, out_of_order, stacked
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation.resting import rests
from tests.linear_models import coupled_system

LATE_S = {"inputs": 0.3, "linear": 0.8}
"""Stream → how late its sensors come at most; others by 0.09 s."""
QUICK = ("pen with a gate", "inputs")
"""Streams on which both engines are quickly compared."""
BITS = ("mean", "covariance")
SYSTEM = coupled_system(3)
Y = np.array([0.3, -0.2, 0.1])


def arrived(name: str, seed: int) -> tuple[Stream, list[Measurement]]:
    stream = STREAMS[name]()
    return stream, out_of_order(stream, seed, LATE_S.get(name, 0.09))


def newest(filter_: Ekf, measurements: list[Measurement]) -> EkfState:
    """Return the state behind measurements, by one call."""
    return filter_.batch(filter_.init(), *stacked(measurements))[0]


def assert_same(one: EkfState | Estimate, other: EkfState | Estimate) -> None:
    a, b = (x.gaussian if isinstance(x, EkfState) else x.state for x in (one, other))
    for name in BITS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    assert one.time_s == other.time_s


def check_every_arrival(name: str, seed: int, every: int) -> None:
    stream, measurements = arrived(name, seed)
    filter_ = ekf(stream)
    state, late = filter_.init(), 0
    for k, measurement in enumerate(measurements, 1):
        late += state.time_s is not None and measurement.time_s < state.time_s
        state, estimate = filter_.step(state, measurement)
        assert Status.LATE not in estimate.status
        if k % every == 0 or k == len(measurements):
            wanted = newest(filter_, in_order(stream.model, measurements[:k]))
            assert_same(estimate, wanted)
            np.testing.assert_array_equal(state.seen, wanted.seen)
            np.testing.assert_array_equal(state.inputs, wanted.inputs)
    assert late > 20


@pytest.mark.parametrize("name", STREAMS)
def test_after_any_arrival_it_is_a_run_in_order(name: str) -> None:
    check_every_arrival(name, seed=1, every=5)


def test_the_body_at_rest_is_found_to_rest() -> None:
    stream, measurements = arrived("at rest", seed=1)
    assert rests(stream.model, *stacked(in_order(stream.model, measurements))).sum() > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", STREAMS)
def test_after_every_arrival_it_is_a_run_in_order(name: str, seed: int) -> None:
    check_every_arrival(name, seed, every=1)


@pytest.mark.usefixtures("interpreted")
def test_without_a_compiler_too() -> None:
    check_every_arrival("pen with a gate", seed=2, every=40)


@needs_compiler
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in STREAMS],
)
def test_compiled_is_interpreted(name: str) -> None:
    stream, measurements = arrived(name, seed=3)
    machine, plain = compiled_and_interpreted(lambda: ekf(stream))
    pairs = zip(steps(machine, measurements), steps(plain, measurements), strict=True)
    for a, b in pairs:
        std = b.state.std
        assert (np.abs(a.state.mean - b.state.mean) <= 1e-12 * std).all()
        np.testing.assert_allclose(a.innovation, b.innovation, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(
            a.innovation_covariance, b.innovation_covariance, rtol=1e-9, atol=1e-15
        )
        assert (a.status, a.time_s, a.iterations) == (b.status, b.time_s, b.iterations)


@pytest.mark.parametrize("name", ["pen with a gate", "inputs"])
def test_a_batch_is_the_steps(name: str) -> None:
    stream, measurements = arrived(name, seed=4)
    filter_ = ekf(stream)
    time_s, y = stacked(measurements)
    cut = len(measurements) // 2 + 1
    state, first = filter_.batch(filter_.init(), time_s[:cut], y[:cut], covariances=True)
    state, second = filter_.batch(state, time_s[cut:], y[cut:], covariances=True)
    one_by_one = steps(filter_, measurements)
    for history, part in ((first, one_by_one[:cut]), (second, one_by_one[cut:])):
        np.testing.assert_array_equal(history.mean, [e.state.mean for e in part])
        np.testing.assert_array_equal(history.covariance, [e.state.covariance for e in part])
        np.testing.assert_array_equal(history.innovation, [e.innovation for e in part])
        assert history.status == tuple(e.status for e in part)
    assert_same(state, one_by_one[-1])


@pytest.mark.parametrize("name", ["pen", "at rest"])
def test_what_arrives_later_changes_nothing_before(name: str) -> None:
    """Its values, its order and its presence."""
    stream, measurements = arrived(name, seed=5)
    filter_, rng, cut = ekf(stream), np.random.default_rng(6), len(measurements) // 2
    before, after = measurements[:cut], measurements[cut:]
    others = [dataclasses.replace(m, y=2 * m.y + 1) for m in after], after[::-1], after[::2]
    _, wanted = filter_.batch(filter_.init(), *stacked(measurements))
    for other in others:
        rng.shuffle(other)
        _, history = filter_.batch(filter_.init(), *stacked([*before, *other]))
        np.testing.assert_array_equal(history.mean[:cut], wanted.mean[:cut])
        np.testing.assert_array_equal(history.std[:cut], wanted.std[:cut])
        assert not np.array_equal(history.mean[cut:], wanted.mean[cut : len(history.mean)])


def test_a_state_may_take_several_ways() -> None:
    stream, measurements = arrived("pen", seed=7)
    filter_, state = ekf(stream), ekf(stream).init()
    for measurement in measurements[:80]:
        state, _ = filter_.step(state, measurement)
    kept = state.memory.copy()
    first = steps_from(filter_, state, measurements[80:])
    again = steps_from(filter_, state, measurements[80:])
    np.testing.assert_array_equal(state.memory, kept)
    for a, b in zip(first, again, strict=True):
        assert_same(a, b)


def steps_from(filter_: Ekf, state: EkfState, measurements: list[Measurement]) -> list[Estimate]:
    found = []
    for measurement in measurements:
        state, estimate = filter_.step(state, measurement)
        found.append(estimate)
    return found


def given(filter_: Ekf, *rows: tuple[float, list[float]]) -> tuple[EkfState, Estimate]:
    state = filter_.init()
    for time_s, y in rows:
        state, estimate = filter_.step(state, Measurement(time_s, np.array(y)))
    return state, estimate


NONE = float("nan")


def test_the_step_tells_the_late_innovation() -> None:
    """Of a row that stands alone, as in order; of one that joins another, its own alone."""
    filter_ = Ekf(SYSTEM.model)
    rows = (1.0, [0.3, NONE, NONE]), (1.2, [NONE, 0.1, NONE]), (1.5, [0.5, 0.2, -0.1])
    _, alone = given(filter_, rows[0], rows[2], rows[1])
    _, wanted = given(filter_, rows[0], rows[1])
    np.testing.assert_array_equal(alone.innovation, wanted.innovation)
    np.testing.assert_array_equal(alone.innovation_covariance, wanted.innovation_covariance)
    joined = (1.0, [0.3, NONE, NONE]), (1.2, [-0.2, NONE, 0.3]), (1.5, [0.5, 0.2, -0.1])
    _, told = given(filter_, *joined, (1.2, [NONE, 0.1, NONE]))
    _, both = given(filter_, joined[0], (1.2, [-0.2, 0.1, 0.3]))
    rows_told = np.array([False, True, False])
    np.testing.assert_array_equal(np.isfinite(told.innovation), rows_told)
    assert told.innovation[1] == both.innovation[1]
    S, noise = told.innovation_covariance, SYSTEM.model.noise_std
    assert S[1, 1] == both.innovation_covariance[1, 1]
    np.testing.assert_array_equal(S[~rows_told][:, ~rows_told], np.diag(noise[~rows_told] ** 2))
    assert told.time_s == 1.5
    assert told.status is Status.SOLVED


def test_late_remarks_are_those_of_the_late_row() -> None:
    filter_ = Ekf(SYSTEM.model)
    rows = (1.0, [0.3, NONE, NONE]), (1.5, [0.5, 0.2, -0.1])
    _, empty = given(filter_, *rows, (1.2, [NONE] * 3))
    assert empty.status is Status.NO_READING
    _, infinite = given(filter_, *rows, (1.2, [float("inf"), NONE, 0.1]))
    assert infinite.status is Status.INFINITE_READING
    _, on_time = given(filter_, rows[0], (1.5, [float("inf"), 0.2, 0.1]), (1.2, [0.1, NONE, NONE]))
    assert on_time.status is Status.SOLVED


def test_the_same_reading_twice_stands_behind_the_first() -> None:
    filter_, first = Ekf(SYSTEM.model), (1.2, [0.1, NONE, NONE])
    again, last = (1.2, [0.4, NONE, NONE]), (1.5, [0.5, 0.2, -0.1])
    state, found = given(filter_, first, last, again)
    assert state.n_rows == 3
    assert_same(found, given(filter_, first, again, last)[1])
    state, joined = given(filter_, first, last, (1.2, [NONE, 0.2, NONE]))
    assert state.n_rows == 2
    assert_same(joined, given(filter_, (1.2, [0.1, 0.2, NONE]), last)[1])


def test_before_the_first() -> None:
    filter_, rows = Ekf(SYSTEM.model), [(1.0 + 0.1 * k, list(Y + k)) for k in range(5)]
    assert_same(given(filter_, *rows[2:], rows[0], rows[1])[1], given(filter_, *rows)[1])


def test_before_all_inputs_are_known_it_is_late() -> None:
    stream = STREAMS["inputs"]()
    filter_, (first, *others) = ekf(stream), stream.measurements[:5]
    state = filter_.init()
    for measurement in others:
        state, before = filter_.step(state, measurement)
    unknown = first.y.copy()
    unknown[stream.model.n_y :] = np.nan
    _, estimate = filter_.step(state, dataclasses.replace(first, y=unknown))
    assert estimate.status is Status.LATE
    assert_same(estimate, before)
    _, estimate = filter_.step(state, first)
    assert estimate.status is Status.SOLVED


@pytest.mark.parametrize("late_samples", [1, 2, 3, 7, 20, 50])
def test_it_reaches_back_as_far_as_it_says(late_samples: int) -> None:
    """At any time: whatever a full log forgets, the rows in reach stay; and it ends somewhere."""
    filter_ = Ekf(SYSTEM.model, EkfConfig(late_samples=late_samples))
    n = 3 * late_samples + 9
    rows = [Measurement(float(k), Y + 0.1 * k) for k in range(n)]
    state, sizes = filter_.init(), []
    for k, row in enumerate(rows):
        state, _ = filter_.step(state, row)
        sizes.append(state.n_rows)
        back = min(late_samples, k + 1)
        late = Measurement(k - back + 0.5, Y)
        after, estimate = filter_.step(state, late)
        assert estimate.status is Status.SOLVED
        assert_same(estimate, newest(filter_, in_order(SYSTEM.model, [*rows[: k + 1], late])))
        assert late_samples <= after.n_rows <= 2 * late_samples + 1 or k < late_samples
    assert max(sizes) == sizes[-1] or max(sizes[late_samples:]) < 2 * late_samples + 2
    _, estimate = filter_.step(state, Measurement(0.5, Y))
    assert estimate.status is Status.LATE


def test_memory_is_constant() -> None:
    stream, measurements = arrived("linear", seed=8)
    filter_ = ekf(stream)
    state = filter_.init()
    for measurement in measurements:
        after, _ = filter_.step(state, measurement)
        assert after.memory.size == state.memory.size
        state = after
    nothing = Ekf(stream.model, EkfConfig(late_samples=0)).init().memory
    n_x, model = stream.model.n_x, stream.model
    row = -(-n_x // 4) * 4
    assert nothing.size == 2 + n_x + row * row + 3 * len(model.sensors) + model.n_u


def test_the_reach_follows_from_the_model() -> None:
    model = STREAMS["reference pen"]().model
    delay_s = max(sensor.delay_s for sensor in model.sensors)
    rate_hz = sum(sensor.rate_hz for sensor in model.sensors if sensor.rate_hz)
    assert default_reach(model) == max(int(np.ceil(2 * delay_s * rate_hz)), 20) > 20
    assert default_reach(SYSTEM.model) == FEWEST == 20


def test_a_negative_number_is_refused() -> None:
    with pytest.raises(InputError, match="late_samples is -1, expected a whole number from 0"):
        EkfConfig(late_samples=-1)


def test_a_state_is_pleasant_to_look_at() -> None:
    filter_ = Ekf(SYSTEM.model)
    start = filter_.init()
    assert start.time_s is None
    assert (
        repr(start) == f"<EkfState before the first measurement: {SYSTEM.model.n_x} states, "
        "back by 0 rows>"
    )
    state, estimate = filter_.step(start, Measurement(1.25, Y))
    assert "at 1.25 s" in repr(state)
    np.testing.assert_array_equal(state.gaussian.mean, estimate.state.mean)
