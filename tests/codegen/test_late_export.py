"""Late measurements in an exported filter: in double precision every bit, in single its digits."""

from __future__ import annotations

import numpy as np
import pytest

from codegen.exportable import exportable
from ekf_baseline.ekf import EkfConfig
from estimation.recording import Measurement
from estimation.status import Status
from tests.closeness import estimate_error
from tests.codegen.exports import exported, told
from tests.ekf_baseline.arrivals import STREAMS, ekf, in_order, out_of_order
from tests.engines import needs_compiler, steps

pytestmark = needs_compiler

LATE = {"late_samples": 40}
CASES = {"pen": 0.09, "linear": 0.8, "reference pen": 0.09, "inputs": 0.3}
"""Stream → how late its sensors come at most, s."""


@pytest.mark.parametrize("name", CASES)
def test_it_is_what_runs_here_to_the_last_bit(name: str) -> None:
    stream = STREAMS[name]()
    measurements = out_of_order(stream, 1, CASES[name])
    ours = told(exported("ekf", stream.model, settings=LATE), measurements)
    for a, b in zip(ours, steps(ekf(stream), measurements), strict=True):
        np.testing.assert_array_equal(a.state.mean, b.state.mean)
        np.testing.assert_array_equal(a.state.covariance, b.state.covariance)
        np.testing.assert_array_equal(a.innovation, b.innovation)
        assert (a.time_s, a.status, a.iterations) == (b.time_s, b.status, b.iterations)


@pytest.mark.cover
@pytest.mark.parametrize("later_s", [0.0, 36_000.0])
@pytest.mark.parametrize("name", ["pen", "linear"])
def test_in_single_precision_it_is_a_run_in_order(name: str, later_s: float) -> None:
    """Readings of one instant find each other whatever the time is."""
    stream = STREAMS[name]()
    arrived = [Measurement(m.time_s + later_s, m.y) for m in out_of_order(stream, 2, CASES[name])]
    estimator = exported("ekf", stream.model, "float", settings=LATE)
    late = told(estimator, arrived)
    ordered = told(estimator, in_order(stream.model, arrived))
    assert not any(Status.LATE in estimate.status for estimate in late)
    assert estimate_error(stream.model, late[-1], ordered[-1]) < 1e-2


def test_a_moment_late_is_taken() -> None:
    """Even by less than single precision resolves: the newest instant stays the newest."""
    model = STREAMS["linear"]().model
    y = np.array([0.1, 0.2, 0.3])
    for real in ("double", "float"):
        estimator = exported("ekf", model, real)
        state, _ = estimator.step(estimator.init(), Measurement(1000.0, y))
        state, before = estimator.step(state, Measurement(1000.01, y))
        _, late = estimator.step(state, Measurement(float(np.nextafter(1000.01, 0)), y))
        assert late.status is Status.SOLVED
        assert late.time_s == before.time_s == 1000.01
        assert (late.state.std < before.state.std).any()


def test_what_it_keeps_can_be_chosen() -> None:
    model = STREAMS["pen"]().model
    sizes = [exportable("ekf", model, late_samples=n).loop.memory.size for n in (0, 5, 40)]
    assert sizes == sorted(sizes)
    assert sizes[0] < 1 + model.n_x + (model.n_x + 3) ** 2 + len(model.sensors) + 1
    assert EkfConfig().late_samples is None
