"""The state-space model as a value: frozen, checked, and able to describe itself."""

from __future__ import annotations

import dataclasses
from typing import Any

import casadi as ca
import numpy as np
import pytest

from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from tests.models.pens import call, every_sensor, pen, random_state
from tests.references.free_states import still_state

CONFIG = {n: pen(n, every_sensor(np.random.default_rng(n))) for n in (5, 6)}
MODEL = {n: pen_model(config) for n, config in CONFIG.items()}
PEN = MODEL[6]
N = PEN.n_x


@pytest.mark.parametrize(
    ("value", "field"),
    [(PEN, "name"), (PEN, "prior"), (PEN, "f"), (PEN.sensors[0], "rate_hz"), (PEN.prior, "mean")],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)
def test_frozen(value: Any, field: str) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(value, field, None)


ARRAYS = {
    "bounds": lambda: PEN.lower,
    "noise": lambda: PEN.noise_std,
    "a sensor's noise": lambda: PEN.sensors[0].noise_std,
}


@pytest.mark.parametrize("name", ARRAYS)
def test_numbers_do_not_change_either(name: str) -> None:
    """What an estimator made of them before would hold for some of its parts only."""
    with pytest.raises(ValueError, match="read-only"):
        ARRAYS[name]()[...] = 1.0


def test_numbers_are_the_models_own() -> None:
    lower = np.full(N, -1.0)
    model = PEN.replace(lower=lower)
    lower[0] = 5.0
    assert model.lower[0] == -1.0


def test_replace_leaves_the_original_alone() -> None:
    other = PEN.replace(name="other")
    assert (other.name, PEN.name) == ("other", "test pen, 6 degrees of freedom")
    assert other.f is PEN.f


def test_bounded() -> None:
    model = MODEL[5]
    bounded = model.bounded(tip_z_m=(0.0, np.inf), elevation_rad=(0.1, 1.4))
    lower, upper = np.full(model.n_x, -np.inf), np.full(model.n_x, np.inf)
    lower[2], lower[4], upper[4] = 0.0, 0.1, 1.4
    assert np.array_equal(bounded.lower, lower)
    assert np.array_equal(bounded.upper, upper)
    assert bounded.inequality.numel_out(0) == 0
    assert np.isinf(model.lower).all()
    assert np.isinf(model.upper).all()
    again = bounded.bounded(tip_x_m=(-1.0, 1.0))
    assert (again.lower[0], again.upper[0], again.upper[4]) == (-1.0, 1.0, 1.4)


def test_bounds_on_what_is_no_state_are_inequalities() -> None:
    """Of the free pen: a tip is a state, an elevation is read from the attitude."""
    bounded = PEN.bounded(tip_z_m=(0.0, np.inf), elevation_rad=(0.1, 1.4))
    lower = np.full(N, -np.inf)
    lower[2] = 0.0
    assert np.array_equal(bounded.lower, lower)
    assert np.isinf(bounded.upper).all()
    assert np.isinf(PEN.lower).all()
    assert PEN.inequality.numel_out(0) == 0
    x = np.zeros(N)
    x[:18] = still_state(1.1, azimuth=2.0, spin=-0.4)
    assert call(bounded.inequality, x) == pytest.approx([1.1 - 1.4, 0.1 - 1.1], abs=1e-14)
    again = bounded.bounded(tip_x_m=(-1.0, 1.0), spin_rad=(-np.inf, 0.0))
    assert (again.lower[0], again.upper[0], again.lower[2]) == (-1.0, 1.0, 0.0)
    expected = [1.1 - 1.4, 0.1 - 1.1, -0.4]
    assert call(again.inequality, x) == pytest.approx(expected, abs=1e-14)


def test_bounds_of_a_pen_file_reach_the_model() -> None:
    bounds = {"bounds": {"elevation_rad": (0.2, 1.5)}}
    model = pen_model(PenConfig(**{**dict(CONFIG[5]), **bounds}))
    assert (model.lower[4], model.upper[4]) == (0.2, 1.5)
    assert np.isinf(np.delete(model.lower, 4)).all()
    free = pen_model(PenConfig(**{**dict(CONFIG[6]), **bounds}))
    x = np.zeros(N)
    x[:18] = still_state(0.9)
    assert call(free.inequality, x) == pytest.approx([0.9 - 1.5, 0.2 - 0.9], abs=1e-14)
    assert np.isinf(free.lower).all()


def test_bound_on_an_unknown_state() -> None:
    with pytest.raises(InputError, match="unknown state tip_q_m; expected one of tip_x_m, tip_y_m"):
        PEN.bounded(tip_q_m=(0.0, 1.0))


@pytest.mark.parametrize("bounds", [(1.0, 1.0), (2.0, 1.0), (np.nan, 1.0), (0.0, np.nan)])
def test_bound_that_leaves_nothing(bounds: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"bound on tip_z_m: lower .* is not below upper"):
        PEN.bounded(tip_z_m=bounds)


def test_constrained_adds_rows() -> None:
    once = PEN.constrained(lambda x: ca.sumsqr(x[:2]) - 0.04)
    twice = once.constrained(lambda x: ca.vertcat(-x[2], x[2] - 0.1))
    x = random_state(np.random.default_rng(1), 6, N - 18)
    expected = [x[0] ** 2 + x[1] ** 2 - 0.04, -x[2], x[2] - 0.1]
    assert call(twice.inequality, x) == pytest.approx(expected, rel=1e-14)
    assert [m.inequality.numel_out(0) for m in (PEN, once, twice)] == [0, 1, 3]


@pytest.mark.parametrize(
    "describe", [repr, lambda model: model._repr_html_()], ids=["text", "html"]
)
@pytest.mark.parametrize("n", [5, 6])
def test_description_names_everything(describe: Any, n: int) -> None:
    text = describe(MODEL[n])
    assert MODEL[n].name in text
    assert len(MODEL[n].state_names) == len(set(MODEL[n].state_names)) == 3 * n + 5
    known = dict(zip(MODEL[n].state_names, MODEL[n].prior.std, strict=True))
    outputs = MODEL[n].outputs
    read = known if outputs is None else dict.fromkeys(outputs.names)
    assert set(known) - set(read) <= {"mrp_x", "mrp_y", "mrp_z"}
    for name in read:
        std = known.get(name)
        line = next(row for row in text.replace("</tr>", "\n").splitlines() if name in row)
        assert std is None or f"{std:.4g}" in line
    for sensor in MODEL[n].sensors:
        assert sensor.name in text
        assert sensor.kind in text
        assert f"{sensor.noise_std[0]:.3g}" in text


def test_stack_in_the_order_of_the_sensors() -> None:
    accel, gyro = np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0])
    y = PEN.stack({"gyro": gyro, "accel": accel})
    assert y.shape == (PEN.n_y,) == (3 + 2 + 6 + 1 + 3,)
    assert np.array_equal(y[:5], [1, 2, 3, 4, 5])
    assert np.isnan(y[5:]).all()
    assert PEN.reading_names[:6] == (
        "accel_x",
        "accel_y",
        "accel_z",
        "gyro_z",
        "gyro_x",
        "camera_x",
    )
    assert np.isnan(PEN.stack({})).all()


@pytest.mark.parametrize("value", [np.zeros(2), np.zeros((3, 1)), 1.0])
def test_stack_checks_shapes(value: Any) -> None:
    with pytest.raises(InputError, match=r"reading of accel has shape .*, expected \(3,\)"):
        PEN.stack({"accel": value})


@pytest.mark.parametrize("n", [5, 6])
def test_rows_need_their_components(n: int) -> None:
    """A row that turns needs the whole rotation vector, every other row its own component."""
    camera = MODEL[n].sensor("camera")
    expected = np.zeros((n, 6), dtype=bool)
    expected[:3, :3] = np.eye(3)
    expected[3:, 3:] = True
    assert np.array_equal(camera.row_needs, expected)
    assert np.array_equal(MODEL[n].sensor("gyro").row_needs, np.eye(2))
    stacked = MODEL[n].row_needs
    assert stacked.shape == (MODEL[n].n_r, MODEL[n].n_y) == (9 + n, 15)
    assert np.array_equal(stacked[5 : 5 + n, 5:11], expected)
    stacked = stacked.copy()
    stacked[5 : 5 + n, 5:11] = False
    assert np.array_equal(stacked[:5, :5], np.eye(5))
    assert np.array_equal(stacked[5 + n :, 11:], np.eye(4))
    assert stacked.sum() == 5 + 4


def test_noise_is_stacked_like_the_rows() -> None:
    parts = [sensor.noise_std for sensor in PEN.sensors]
    assert np.array_equal(PEN.noise_std, np.concatenate(parts))
    assert (PEN.n_r, MODEL[5].n_r) == (15, 14)


def test_unknown_sensor() -> None:
    with pytest.raises(InputError, match=r"lidar is not part of .*; expected accel, gyro, c"):
        PEN.sensor("lidar")
    assert PEN.sensor("gyro").name == "gyro"


def test_sensors_are_chosen_by_name_and_in_order() -> None:
    model = pen_model(CONFIG[6], ("gyro", "accel"), writing_area=False)
    assert [sensor.name for sensor in model.sensors] == ["gyro", "accel"]
    assert model.state_names[18:20] == ("gyro_bias_z_rad_s", "gyro_bias_x_rad_s")
    assert pen_model(CONFIG[6], ["camera"]).n_x == 18
    with pytest.raises(
        InputError, match="sensor lidar is not in the pen test pen; expected one of"
    ):
        pen_model(CONFIG[6], ["lidar"])
    with pytest.raises(InputError, match="sensors gyro, gyro: a name appears twice"):
        pen_model(CONFIG[6], ["gyro", "gyro"])
