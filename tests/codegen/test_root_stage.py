"""Square roots: the covariance form's estimates, and a covariance in any arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from codegen.exportable import exportable
from codegen.roots import in_roots, root
from estimation.estimate import Estimate
from estimation.recording import Measurement
from estimation.status import Status
from models.arrays import Array
from models.gaussian import GaussianState
from tests.closeness import estimate_error
from tests.codegen.exports import SHORT, exported, told
from tests.disturbed import ABSURD_AT, disturbed
from tests.engines import needs_compiler
from tests.estimation import pens
from tests.linear_models import LinearSystem, constant_acceleration_system
from tests.mhe import pendulum

pytestmark = needs_compiler

RUN = pens.draw_pen_run(60, seed=11)
ACCEL, *OTHERS = RUN.model.sensors
PEN = RUN.model.replace(sensors=(replace(ACCEL, reading_limit=40.0), *OTHERS))
ALIKE_STD = 1e-9


@pytest.mark.parametrize("name", ["ekf", "mhe-rti"])
def test_both_forms_say_the_same(name: str) -> None:
    measurements = disturbed(RUN.measurements, limit=39.99, outlier=3.0)
    del measurements[ABSURD_AT]  # what is NaN of its innovation differs
    roots = told(exported(name, PEN, "double", "root"), measurements)
    covariances = told(exported(name, PEN, "double", "covariance"), measurements)
    for a, b in zip(roots, covariances, strict=True):
        assert estimate_error(PEN, a, b) < ALIKE_STD
        assert a.status is b.status


@pytest.mark.parametrize(("name", "real"), [("ekf", "double"), ("mhe-rti", "float")])
def test_an_absurd_reading_spoils_nothing(name: str, real: str) -> None:
    measurements = list(RUN.measurements)
    absurd = 1e200 if real == "double" else 1e30
    measurements.insert(ABSURD_AT, replace(measurements[ABSURD_AT - 1], y=np.full(PEN.n_y, absurd)))
    free = PEN.replace(sensors=RUN.model.sensors)
    estimates = told(exported(name, free, real, "root"), measurements)
    assert Status.NOT_FINITE in estimates[ABSURD_AT].status
    for estimate in estimates:
        assert np.isfinite(estimate.state.mean).all()
        assert smallest_eigenvalue(estimate) > 0
    assert all(e.status is Status.SOLVED for e in estimates[ABSURD_AT + 2 :])


def test_losses_scale_rows_and_noises_alike() -> None:
    model, measurements = pendulum.model(), pendulum.simulate(40, seed=3)
    settings = {"horizon": 4, "huber": {"level": 2.0}, "sparse_noise": 1.0}
    roots = told(exported("mhe-rti", model, "double", "root", settings), measurements)
    covariances = told(exported("mhe-rti", model, "double", "covariance", settings), measurements)
    for a, b in zip(roots, covariances, strict=True):
        assert estimate_error(model, a, b) < ALIKE_STD


def hard_system() -> LinearSystem:
    """Nothing is known of the start, and readings are good: variances over 14 orders."""
    system = constant_acceleration_system(1, density=1.0)
    position, acceleration = system.model.sensors
    exact = replace(position, noise_std=np.array([1e-4]))
    prior = GaussianState(system.model.prior.mean, 1e6 * np.eye(3))
    model = system.model.replace(sensors=(exact, acceleration), prior=prior)
    return replace(system, model=model, R=np.diag([1e-8, 0.09]))


def smallest_eigenvalue(estimate: Estimate) -> float:
    """Of the estimate's correlation; negative where there is no covariance."""
    P = estimate.state.covariance
    variances = np.diag(P)
    if not (variances > 0).all():
        return -np.inf
    std = np.sqrt(variances)
    return float(np.linalg.eigvalsh(P / np.outer(std, std)).min())


def test_roots_last_in_single_precision() -> None:
    system = hard_system()
    truth = np.array([0.1, -0.2, 0.3])
    measurements = [
        Measurement(t, np.array([truth[0] + truth[1] * t + truth[2] * t**2 / 2, np.nan]))
        for t in np.arange(200) / 100
    ]
    wanted = system.textbook(measurements)
    roots = told(exported("ekf", system.model, "float", "root"), measurements)
    for estimate, posterior in zip(roots, wanted, strict=True):
        std = np.sqrt(np.diag(posterior.covariance))
        assert smallest_eigenvalue(estimate) > 0
        np.testing.assert_allclose(estimate.state.std, std, rtol=1e-3)
    plain = plain_deviations(system, measurements)
    assert not (np.abs(plain / np.sqrt(np.diag(wanted[-1].covariance)) - 1) < 1).all(), (
        "or roots were not needed"
    )


def plain_deviations(system: LinearSystem, measurements: Sequence[Measurement]) -> Array:
    """What P - W Wᵀ comes to in single precision, (n_x,)."""
    single = np.float32
    P, before = system.model.prior.covariance.astype(single), measurements[0].time_s
    h, r = system.H[0].astype(single), single(system.R[0, 0])
    with np.errstate(invalid="ignore"):
        for measurement in measurements:
            dt = measurement.time_s - before
            F = system.F(dt).astype(single)
            P = F @ P @ F.T + system.Q(dt).astype(single)
            W = P @ h / np.sqrt(h @ P @ h + r)
            P, before = P - np.outer(W, W), measurement.time_s
        return np.sqrt(np.diag(P))


def test_a_root_is_the_cholesky_factor() -> None:
    factor = np.array([[2.0, 0.0], [-1.0, 3.0]])
    np.testing.assert_allclose(root(factor @ factor.T), factor, rtol=1e-15)


def test_tables_of_covariances_become_roots() -> None:
    exported_loop = exportable("mhe-rti", PEN, **SHORT["mhe-rti"])
    changed, start = in_roots(PEN, exported_loop.loop, exported_loop.start)
    n_x = PEN.n_x
    constant = changed.fields["constant_covariance"][:n_x, :n_x]
    np.testing.assert_allclose(constant @ constant.T, PEN.prior.covariance, rtol=1e-14)
    prior = changed.memory.view(start, "prior_covariance")[:n_x, :n_x]
    np.testing.assert_allclose(prior @ prior.T, PEN.prior.covariance, rtol=1e-14)


def test_losses_and_gates_of_the_filter_alike() -> None:
    """A gate that opens puts the prior on top of a root, too."""
    measurements = disturbed(RUN.measurements, limit=39.99, outlier=3.0)
    del measurements[ABSURD_AT]
    settings = {"huber": {"camera": 2.0}, "gate_probability": {"accel": 0.5, "gyro": 0.5}}
    roots = told(exported("ekf", PEN, "double", "root", settings), measurements)
    covariances = told(exported("ekf", PEN, "double", "covariance", settings), measurements)
    for a, b in zip(roots, covariances, strict=True):
        assert estimate_error(PEN, a, b) < ALIKE_STD
        assert a.status is b.status
    gated = [Status.GATED in estimate.status for estimate in roots]
    assert 0 < sum(gated) < len(gated)
