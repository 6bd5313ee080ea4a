"""What sensors can see: the Gramian's null space against the one derived on paper."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.linalg import subspace_angles
from scipy.spatial.transform import Rotation

from estimation.observability import Observability, observability_matrix
from estimation.recording import Measurement
from models.arrays import Array
from models.motion import Motion
from models.sensor_kinds.accelerometer import Accelerometer
from models.sensor_kinds.gyroscope import Gyroscope
from models.state_space import StateSpaceModel
from tests.estimation.exact_motions import (
    ACCEL_AT,
    ACCELERATIONS,
    CENTRE,
    CONFIGURATIONS,
    RATES,
    SENSORS,
    STRAIGHT_UP,
    TIP_SEEN_BY,
    configured,
    first_state,
    motion,
    second,
)
from tests.models.pens import ACCELEROMETER, GYROSCOPE, call
from tests.references import unobservable, unobservable_free
from tests.references.free_tangent import retracted

pytestmark = pytest.mark.usefixtures("interpreted")

ANGLE = 1e-9
"""Principal angles in prior units, rad. Measured: 6e-13, rounding of the readings' changes
(up to 2e4 deviations) over the weakest of them that show (0.1)."""

PAPER: dict[int, Any] = {5: unobservable, 6: unobservable_free}
"""Degrees of freedom → where its subspaces are derived."""

LIVELY: dict[int, Any] = {5: {}, 6: {"motion": Motion()}}
"""A free pen's tip whose acceleration changes its direction: about a constant one it can turn."""

NUMBER_LEFT_AT_REST = {
    (5, "accel"): (10, 2, 0),
    (6, "accel"): (11, 3, 0),
    (5, "gyro"): (11, 2, 0),
    (6, "gyro"): (12, 3, 0),
    (5, "accel+gyro"): (8, 1, 0),
    (6, "accel+gyro"): (9, 1, 0),
    (5, "two accels"): (9, 2, 0),
    (6, "two accels"): (10, 2, 0),
}


def assert_same_subspace(found: Observability, paper: Array) -> None:
    """The same subspace, and a gap around `ROUNDING`, so that this number decides nothing."""
    s = found.singular_values
    assert not ((s > 1e-10) & (s < 1e-2)).any()
    assert (np.diff(s) <= 0).all()
    assert found.unobservable.shape == paper.shape
    assert found.rank == len(paper) - paper.shape[1]
    if paper.shape[1]:
        in_prior_units = paper / found.prior_std[:, None]
        assert subspace_angles(in_prior_units, found.unobservable).max() < ANGLE


@pytest.mark.parametrize(("n_q", "inertial", "tip_seen_by"), CONFIGURATIONS)
def test_held_still_it_is_the_papers_subspace(n_q: int, inertial: str, tip_seen_by: str) -> None:
    x = first_state(n_q)
    found = motion(configured(n_q, inertial, tip_seen_by), x, second()).observability
    paper = PAPER[n_q].held_still(inertial, tip_seen_by, x, np.array(ACCEL_AT))
    assert (
        paper.shape[1] == NUMBER_LEFT_AT_REST[n_q, inertial][list(TIP_SEEN_BY).index(tip_seen_by)]
    )
    assert_same_subspace(found, paper)


@pytest.mark.parametrize(("n_q", "inertial", "tip_seen_by"), CONFIGURATIONS)
def test_in_motion_it_is_the_papers_subspace(n_q: int, inertial: str, tip_seen_by: str) -> None:
    x = first_state(n_q, RATES, ACCELERATIONS)
    found = motion(configured(n_q, inertial, tip_seen_by), x, second()).observability
    assert_same_subspace(found, PAPER[n_q].in_motion(inertial, tip_seen_by, x, np.array(CENTRE)))


@pytest.mark.parametrize("n_q", [5, 6])
def test_a_tip_that_accelerates_straight_up_hides_its_heading(n_q: int) -> None:
    """A free pen's velocity turns with the attitude: its tip goes straight up too."""
    rates = RATES if n_q == 5 else RATES * [0, 0, 1, 1, 1, 1]
    x = first_state(n_q, rates, STRAIGHT_UP)
    found = motion(configured(n_q, "accel+gyro", "area"), x, second()).observability
    assert_same_subspace(found, PAPER[n_q].in_motion("accel+gyro", "area", x, np.array(CENTRE)))
    heading = "azimuth_rad" if n_q == 5 else "turning about the vertical"
    assert [direction.words for direction in found.directions] == [f"{heading} alone"]


@pytest.mark.parametrize("tip_seen_by", ["nothing", "area"])
def test_off_the_axis_the_papers_subspace_turns_with_the_mounting(tip_seen_by: str) -> None:
    place, x = (0.03, -0.02, 0.1), first_state(6)
    sensors = {**SENSORS, "accel": Accelerometer(**ACCELEROMETER, position_m=place)}
    found = motion(configured(6, "accel", tip_seen_by, sensors), x, second()).observability
    paper = unobservable_free.held_still("accel", tip_seen_by, x, np.array(place))
    assert_same_subspace(found, paper)
    on_axis = unobservable_free.held_still("accel", tip_seen_by, x, np.array(ACCEL_AT))
    assert subspace_angles(paper, on_axis).max() > 1e-3  # the mounting does matter


@pytest.mark.parametrize("n_q", [5, 6])
def test_an_azimuth_that_only_the_linearised_area_shows_is_not_seen(n_q: int) -> None:
    """Turned about the area's centre, a motion has the same readings and distances.

    The matrix alone has full rank: it takes the area's constant for a reading of the tip.
    """
    x, centre = first_state(n_q, RATES, ACCELERATIONS), np.array(CENTRE)
    along = motion(configured(n_q, "accel+gyro", "area", **LIVELY[n_q]), x, second())
    matrix = observability_matrix(along.model, along.measurements, along.states)
    assert np.linalg.svd(matrix, compute_uv=False)[-1] > 1e-2
    assert along.observability.rank == 3 * n_q - 1

    angle = 0.6
    turn = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
    blocks = x.reshape(3, n_q).copy()
    blocks[0, :3] -= centre
    blocks[:, :3] = blocks[:, :3] @ turn.T
    blocks[0, :3] += centre
    if n_q == 5:
        blocks[0, 3] += angle
    else:
        attitude = Rotation.from_matrix(turn) * Rotation.from_mrp(blocks[0, 3:])
        blocks[0, 3:] = attitude.as_mrp()
    turned = motion(along.model, blocks.ravel(), second())
    assert np.abs(turned.states - along.states).max() > 0.1
    inertial, same = (np.array([m.y[:6] for m in one.measurements]) for one in (along, turned))
    np.testing.assert_allclose(same, inertial, rtol=0, atol=1e-12)
    area = along.model.sensor("area")
    distances = [
        [np.linalg.norm(call(area.residual, area.constant_reading, x)) for x in one.states]
        for one in (along, turned)
    ]
    np.testing.assert_allclose(distances[1], distances[0], rtol=1e-12)


def test_a_reading_of_the_tip_shows_the_azimuth() -> None:
    """What the area is not: a sensor that does measure where the tip is."""
    x = first_state(6, RATES, ACCELERATIONS)
    model = configured(6, "accel+gyro", "area", **LIVELY[6])
    *inertial, area = model.sensors
    tracker = dataclasses.replace(area, constant_reading=None)
    tracked = motion(model.replace(sensors=(*inertial, tracker)), x, second())
    assert tracked.observability.directions == ()


def biased(inertial: tuple[str, ...]) -> dict[str, Any]:
    """The sensors, those of a choice with a bias state."""
    biased_sensors = {
        "accel": Accelerometer(**ACCELEROMETER, position_m=ACCEL_AT, bias_std_m_s2=0.3),
        "gyro": Gyroscope(**GYROSCOPE, position_m=ACCEL_AT, bias_std_rad_s=0.03),
    }
    return {**SENSORS, **{name: biased_sensors[name] for name in inertial}}


NUMBER_LEFT_WITH_BIASES = {
    ("accel", ("accel",)): (14, 5, 0),
    ("gyro", ("gyro",)): (15, 6, 0),
    ("accel+gyro", ("accel", "gyro")): (13, 4, 0),
    ("accel+gyro", ("accel",)): (12, 3, 0),
    ("accel+gyro", ("gyro",)): (10, 2, 0),
}


@pytest.mark.cover
@pytest.mark.parametrize(("inertial", "biases"), NUMBER_LEFT_WITH_BIASES)
@pytest.mark.parametrize("tip_seen_by", TIP_SEEN_BY)
def test_biases_of_a_free_pen_hide_as_the_paper_says(
    inertial: str, biases: tuple[str, ...], tip_seen_by: str
) -> None:
    """An accelerometer's with a tilt, a gyroscope's with a rate of turning."""
    model = configured(6, inertial, tip_seen_by, biased(biases))
    x = np.concatenate([first_state(6), 0.01 * np.arange(1, 3 * len(biases) + 1)])
    found = motion(model, x, second()).observability
    paper = unobservable_free.held_still(
        inertial, tip_seen_by, x, np.array(ACCEL_AT), biases=biases
    )
    numbers = NUMBER_LEFT_WITH_BIASES[inertial, biases]
    assert paper.shape[1] == numbers[list(TIP_SEEN_BY).index(tip_seen_by)]
    assert_same_subspace(found, paper)


def stacked_readings(model: StateSpaceModel, x: Array, times: Array) -> Array:
    """All readings (n, n_y) of a motion from a first state."""
    return np.array([m.y for m in motion(model, x, times).measurements])


def test_matrix_is_the_derivative_of_all_readings_by_the_first_state() -> None:
    """Five-point differences of readings simulated forward, over prior and noise, with gaps."""
    model = configured(6, "accel+gyro", "camera")
    times = np.array([0.0, 0.013, 0.1, 0.11, 0.4, 0.55])
    x = first_state(6, RATES, ACCELERATIONS)
    along = motion(model, x, times)
    gaps = [np.array([1, 3]), np.array([], dtype=int), np.arange(12), np.arange(6, 12)]
    gaps += [np.arange(9, 12), np.array([], dtype=int)]
    measurements = []
    for measurement, gap in zip(along.measurements, gaps, strict=True):
        y = measurement.y.copy()
        y[gap] = np.nan
        measurements.append(Measurement(measurement.time_s, y))
    seen_turn = Rotation.from_rotvec(stacked_readings(model, x, times)[:, 9:])

    def readings(amount: float, column: int) -> Array:
        """Readings; those of orientation as a turn in body axes from the camera's own."""
        y = stacked_readings(model, retracted(x, amount * np.eye(18)[column]), times)
        turn = Rotation.from_rotvec(y[:, 9:]).inv() * seen_turn
        return np.hstack([y[:, :9], -turn.as_rotvec()])

    h = 1e-3
    columns = [
        (8 * (readings(h, i) - readings(-h, i)) - readings(2 * h, i) + readings(-2 * h, i))
        / (12 * h)
        for i in range(18)
    ]
    expected = np.stack(columns, axis=-1) / model.noise_std[:, None] * model.prior.std
    for row, gap in enumerate(gaps):
        expected[row, gap] = 0.0
    found = observability_matrix(model, measurements, along.states).reshape(expected.shape)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    for row, gap in enumerate(gaps):
        assert not found[row, gap].any()
