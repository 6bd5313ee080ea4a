"""The filter's loop in C is the loop in Python, to the last bits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf, EkfConfig
from estimation.status import Status
from models.gaussian import GaussianState
from tests.closeness import estimate_error
from tests.disturbed import ABSURD_AT, EMPTY_AT, INFINITE_AT, LATE_AT, SATURATED_AT, disturbed
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens

pytestmark = [needs_compiler, pytest.mark.usefixtures("optimised")]

TOLERANCE_STD = 1e-12
RUN = pens.draw_pen_run(60, seed=11)
ACCEL, *OTHERS = RUN.model.sensors
MODEL = RUN.model.replace(sensors=(replace(ACCEL, reading_limit=40.0), *OTHERS))


@pytest.mark.parametrize(
    ("gate", "late_samples"), [(None, None), (None, 0), (0.9, None), (0.999, 0)]
)
def test_every_step(gate: float | None, late_samples: int | None) -> None:
    measurements = disturbed(RUN.measurements, limit=39.99, outlier=3.0)
    config = EkfConfig(gate_probability=gate, late_samples=late_samples)
    machine, plain = compiled_and_interpreted(lambda: Ekf(MODEL, config))
    estimates = steps(machine, measurements)
    for a, b in zip(estimates, steps(plain, measurements), strict=True):
        assert estimate_error(MODEL, a, b) < TOLERANCE_STD
        assert a.status is b.status
        assert a.time_s == b.time_s
        assert np.isfinite(a.state.mean).all()
    status = [estimate.status for estimate in estimates]
    assert (status[LATE_AT] is Status.LATE) == (late_samples == 0)
    assert status[EMPTY_AT] is Status.NO_READING
    assert Status.INFINITE_READING in status[INFINITE_AT]
    assert Status.SATURATED in status[ABSURD_AT]
    assert Status.SATURATED in status[SATURATED_AT]
    assert any(Status.GATED in s for s in status) == (gate is not None)


def test_angles_stay_within_a_turn_where_a_step_gives_no_number() -> None:
    """Then the prediction comes back, whose transition does not know angles."""
    mean = RUN.model.prior.mean.copy()
    mean[3], mean[8] = np.pi - 0.01, 5.0
    model = RUN.model.replace(prior=GaussianState(mean, RUN.model.prior.covariance))
    absurd = replace(RUN.measurements[1], time_s=0.02, y=np.full(12, 1e200))
    nothing = replace(RUN.measurements[0], time_s=0.0, y=np.full(12, np.nan))
    for ekf in compiled_and_interpreted(lambda: Ekf(model)):
        _, estimate = steps(ekf, [nothing, absurd])
        assert Status.NOT_FINITE in estimate.status
        assert estimate.state.mean[3] == pytest.approx(-np.pi + 0.09, abs=1e-9)
