"""A history by names: of a free pen, whose attitude is no state to read, and of any other."""

from __future__ import annotations

import csv
import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ekf_baseline.ekf import Ekf
from estimation.estimate import EstimateHistory
from estimation.estimator import run, run_measurements
from estimation.outputs import outputs_of
from estimation.recording import Truth
from models.errors import InputError
from models.pen import pen_model
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from tests.linear_models import constant_acceleration_system
from tests.references.free_tangent import heading_of

pytestmark = pytest.mark.usefixtures("interpreted")

SENSORS = ("accel", "gyro")
READ = (
    *("tip_x_m", "tip_y_m", "tip_z_m", "azimuth_rad", "elevation_rad", "spin_rad"),
    *("attitude_w", "attitude_x", "attitude_y", "attitude_z"),
    *("tip_x_velocity_m_s", "tip_y_velocity_m_s", "tip_z_velocity_m_s"),
    *("body_rate_x_rad_s", "body_rate_y_rad_s", "body_rate_z_rad_s"),
    *("tip_x_acceleration_m_s2", "tip_y_acceleration_m_s2", "tip_z_acceleration_m_s2"),
    *("body_acceleration_x_rad_s2", "body_acceleration_y_rad_s2", "body_acceleration_z_rad_s2"),
    *("accel_bias_x_m_s2", "accel_bias_y_m_s2", "accel_bias_z_m_s2"),
    *("gyro_bias_x_rad_s", "gyro_bias_y_rad_s", "gyro_bias_z_rad_s"),
)


@cache
def model() -> StateSpaceModel:
    return pen_model("reference", SENSORS)


@cache
def history() -> EstimateHistory:
    recording = simulate("reference", SENSORS, motion="handwriting", duration_s=0.3, seed=5)
    return run(Ekf(model()), recording, covariances=True)


@cache
def plain() -> EstimateHistory:
    system = constant_acceleration_system(1)
    measurements = system.simulate(0.02 * np.arange(12), np.random.default_rng(8), missing=0.3)
    return run_measurements(Ekf(system.model), measurements)


def test_names_are_what_people_read() -> None:
    assert history().names == READ
    assert plain().names == plain().state_names


@pytest.mark.parametrize("of", [history, plain])
def test_values_are_the_columns_of_names(of: object) -> None:
    found: EstimateHistory = of()  # type: ignore[operator]
    assert found.values.shape == found.values_std.shape == (len(found), len(found.names))
    for i, name in enumerate(found.names):
        assert found.index(name) == i
        np.testing.assert_array_equal(found.values[:, i], found.column(name))
        np.testing.assert_array_equal(found.values_std[:, i], found.std_of(name))


def test_a_column_is_a_state_or_a_derived_output() -> None:
    found = history()
    for name in set(found.names) & set(found.state_names):
        i = found.state_names.index(name)
        np.testing.assert_array_equal(found.column(name), found.mean[:, i])
        if name not in found.derived_names:
            np.testing.assert_array_equal(found.std_of(name), found.std[:, i])
    attitude = Rotation.from_mrp(found.mean[:, 3:6])
    azimuth, lean, spin = attitude.as_euler("ZYZ").T
    np.testing.assert_allclose(found.column("azimuth_rad"), azimuth, atol=1e-13)
    np.testing.assert_allclose(found.column("elevation_rad"), np.pi / 2 - lean, atol=1e-13)
    np.testing.assert_allclose(found.column("spin_rad"), spin, atol=1e-13)


def test_a_velocitys_deviation_is_that_in_the_world() -> None:
    """A velocity turns with the attitude: v's covariance is P_vv + [v]× N P_θθ Nᵀ [v]×ᵀ + …"""
    found, V, SIGMA = history(), slice(6, 9), slice(3, 6)
    for k in (3, 20):
        x, P = found.mean[k], found.covariance[k]
        N, v = heading_of(Rotation.from_mrp(x[SIGMA])).as_matrix(), x[V]
        J = np.zeros((3, len(x)))
        J[:, V] = np.eye(3)
        J[:, SIGMA] = np.cross(N.T, v).T  # δϑ × v with δϑ = N d_θ
        std = np.sqrt(np.diag(J @ P @ J.T))
        names = [f"tip_{axis}_velocity_m_s" for axis in "xyz"]
        np.testing.assert_allclose([found.std_of(name)[k] for name in names], std, rtol=1e-12)


def test_unknown_names_are_refused() -> None:
    for ask in (history().column, history().std_of, history().index):
        with pytest.raises(InputError, match="state yaw_rad is unknown, expected one of tip_x_m"):
            ask("yaw_rad")
    with pytest.raises(InputError, match="state mrp_x is unknown"):
        history().index("mrp_x")


def test_angles_of_a_free_pen_are_circular_but_the_elevation() -> None:
    circular = {name for name in history().names if history().is_circular(name)}
    assert circular == {"azimuth_rad", "spin_rad"}
    assert not any(plain().is_circular(name) for name in plain().names)


def test_errors_are_estimate_minus_truth_the_short_way_round() -> None:
    found = history()
    shift = np.zeros(len(READ))
    for name, amount in (("azimuth_rad", 6.0), ("spin_rad", -4.0), ("elevation_rad", 0.3)):
        shift[READ.index(name)] = amount
    shift[READ.index("body_rate_x_rad_s")] = -7.0
    truth = Truth(found.time_s, READ, found.values - shift)
    expected = shift.copy()
    for name in ("azimuth_rad", "spin_rad"):
        amount = shift[READ.index(name)]
        expected[READ.index(name)] = np.angle(np.exp(1j * amount))
    errors = found.errors(truth)
    assert errors.shape == (len(found), len(READ))
    np.testing.assert_allclose(errors, np.tile(expected, (len(found), 1)), rtol=0, atol=1e-13)


def test_errors_of_what_the_truth_does_not_have_are_nan() -> None:
    found = history()
    truth = Truth(found.time_s, ("azimuth_rad",), np.zeros((len(found), 1)))
    errors = found.errors(truth)
    known = np.array(READ) == "azimuth_rad"
    assert np.isfinite(errors[:, known]).all()
    assert np.isnan(errors[:, ~known]).all()
    late = Truth(found.time_s + 1, ("azimuth_rad",), np.zeros((len(found), 1)))
    with pytest.raises(InputError, match="no truth at 0 s"):
        found.errors(late)


def test_the_simulated_truth_has_every_name() -> None:
    recording = simulate("reference", SENSORS, motion="turn", duration_s=0.1)
    assert recording.truth is not None
    assert set(READ) <= set(recording.truth.names)
    assert np.isfinite(run(Ekf(model()), recording).errors(recording.truth)).all()


def test_a_table_has_what_people_read_and_no_hidden_state(tmp_path: Path) -> None:
    table = history().to_pandas()
    deviations = [f"{name}_std" for name in READ]
    assert list(table.columns) == [
        *("time_s", *READ, *deviations, "status", "iterations", "step_time_s")
    ]
    np.testing.assert_array_equal(table[list(READ)], history().values)
    np.testing.assert_array_equal(table[deviations], history().values_std)
    path = tmp_path / "pen.csv"
    history().to_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(table.columns)
    assert not [name for name in rows[0] if "mrp" in name]
    for name in (*READ, *deviations):
        assert [float(row[name]) for row in rows] == table[name].tolist()


def assert_rows(part: EstimateHistory, rows: object) -> None:
    whole = history()
    assert part.derived_names == whole.derived_names
    assert part.outputs is whole.outputs
    for name in ("derived", "derived_std", "values", "values_std"):
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows])


def test_parts_keep_what_is_derived() -> None:
    whole = history()
    rows = np.array([2, 5, 9])
    assert_rows(whole[3:9], slice(3, 9))
    assert_rows(whole[rows], rows)
    assert_rows(whole.at(whole.time_s[rows]), rows)
    assert_rows(whole.between(float(whole.time_s[4]), float(whole.time_s[6])), slice(4, 7))
    assert_rows(whole[:0], slice(0, 0))


def test_joined_parts_keep_what_is_derived() -> None:
    whole = history()
    parts = [whole[:7], whole[7:7], whole[7:20], whole[20:]]
    assert_rows(EstimateHistory.joined(parts), slice(None))
    assert_rows(EstimateHistory.joined(iter(parts), len(whole)), slice(None))


def test_a_stream_without_measurements_has_names_and_no_rows() -> None:
    none = run_measurements(Ekf(model()), [])
    assert none.names == READ
    assert none.values.shape == none.values_std.shape == (0, len(READ))
    assert list(none.to_pandas().columns) == list(history().to_pandas().columns)


def test_a_history_made_by_hand_needs_no_outputs() -> None:
    hand = dataclasses.replace(plain(), difference=None)
    truth = Truth(hand.time_s, hand.names, hand.mean - 0.25)
    np.testing.assert_allclose(hand.errors(truth), 0.25, rtol=0, atol=1e-12)
    assert hand.derived.shape == hand.derived_std.shape == (len(hand), 0)
    assert outputs_of(model()).names == READ
