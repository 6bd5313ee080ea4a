"""What people read of a free pen, against SciPy's rotations, and bounds on it."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from models.arrays import Array
from models.free_kinematics import ANGLES, QUATERNION
from models.free_pen import N_FREE, SIGMA
from models.outputs import Outputs
from models.pen import pen_model
from models.rotation import world_to_body
from models.state_space import StateSpaceModel
from tests.models.pens import call, every_sensor, matrix, pen, random_state
from tests.references.free_states import body_to_world, still_state

ROUNDING = 1e-13
N_BIASES = 5
SEEDS = range(12)
_ANGLES = ca.SX.sym("angles", 3)
WORLD_TO_BODY = ca.Function("B", [_ANGLES], [world_to_body(_ANGLES[0], _ANGLES[1], _ANGLES[2])])


@cache
def free_model() -> tuple[StateSpaceModel, Outputs]:
    model = pen_model(pen(6, every_sensor(np.random.default_rng(6))))
    assert model.outputs is not None
    return model, model.outputs


def read(x: Array) -> dict[str, float]:
    """Return name → what people read of a state."""
    _, outputs = free_model()
    return dict(zip(outputs.names, call(outputs.function, x), strict=True))


def free(*angles: float) -> Array:
    """A still pen (n_x,) at azimuth, elevation and spin."""
    model, _ = free_model()
    x = np.zeros(model.n_x)
    x[:N_FREE] = still_state(angles[1], angles[0], angles[2])
    return x


@pytest.mark.parametrize("seed", SEEDS)
def test_angles_are_those_of_the_one_rotation(seed: int) -> None:
    """`world_to_body` of the angles is SciPy's rotation of σ; and they are those it was made of."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform([-np.pi, -np.pi / 2, -np.pi], [np.pi, np.pi / 2, np.pi])
    x = free(*angles)
    found = read(x)
    assert [found[name] for name in ANGLES] == pytest.approx(angles, abs=1e-11)
    B = matrix(WORLD_TO_BODY, [found[name] for name in ANGLES])
    assert pytest.approx(Rotation.from_mrp(x[SIGMA]).as_matrix().T, abs=ROUNDING) == B


@pytest.mark.parametrize("elevation", [np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize(("azimuth", "spin"), [(0.0, 0.0), (0.7, -0.3), (-3.0, 2.0)])
def test_upright_the_angles_still_give_the_attitude(
    elevation: float, azimuth: float, spin: float
) -> None:
    """Azimuth and spin are not told apart there; what they make together is right."""
    x = free(azimuth, elevation, spin)
    found = read(x)
    assert found["elevation_rad"] == pytest.approx(elevation, abs=1e-7)
    B = matrix(WORLD_TO_BODY, [found[name] for name in ANGLES])
    level = np.cos(found["elevation_rad"])
    assert level < 1e-7
    axis = Rotation.from_mrp(x[SIGMA]).as_matrix().T[:, 2]
    assert B[:, 2] == pytest.approx(axis, abs=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_quaternion_is_scipys_with_w_at_least_zero(seed: int) -> None:
    rng = np.random.default_rng(seed)
    R = Rotation.random(rng=rng)
    for sigma in (R.as_mrp(), -R.as_mrp() / (R.as_mrp() @ R.as_mrp())):
        x = free(0.0, 0.0, 0.0)
        x[SIGMA] = sigma
        found = np.array([read(x)[name] for name in QUATERNION])
        expected = R.as_quat(canonical=True)[[3, 0, 1, 2]]
        if np.linalg.norm(sigma) <= 1:
            assert found == pytest.approx(expected, abs=1e-15)
            assert found[0] >= 0
        else:  # an attitude that no model returns: the same turn, of the other sign
            assert -found == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_all_else_is_the_state_under_its_own_name(seed: int) -> None:
    model, outputs = free_model()
    x = random_state(np.random.default_rng(seed), 6, N_BIASES)
    found, state = read(x), dict(zip(model.state_names, x, strict=True))
    shown = set(ANGLES) | set(QUATERNION)
    assert set(outputs.names) - shown == set(state) - {"mrp_x", "mrp_y", "mrp_z"}
    assert all(found[name] == state[name] for name in set(outputs.names) - shown)
    units = dict(zip(outputs.names, outputs.units, strict=True))
    of_state = dict(zip(model.state_names, model.state_units, strict=True))
    assert all(units[name] == of_state[name] for name in set(outputs.names) - shown)
    assert [units[name] for name in (*ANGLES, *QUATERNION)] == ["rad"] * 3 + ["1"] * 4
    wrapped = dict(zip(outputs.names, outputs.wrapped, strict=True))
    assert [name for name in wrapped if wrapped[name]] == ["azimuth_rad", "spin_rad"]


def test_five_degrees_of_freedom_are_read_by_their_states() -> None:
    assert pen_model(pen(5, every_sensor(np.random.default_rng(5)))).outputs is None


def rows(bounds: dict[str, tuple[float, float]], *angles: float) -> Array:
    """Rows of the inequality, which is kept where none is above zero."""
    model, _ = free_model()
    return call(model.bounded(**bounds).inequality, free(*angles))


def test_bounds_on_either_side_and_on_both() -> None:
    both = rows({"elevation_rad": (0.2, 1.4)}, 0.5, 1.0, 0.0)
    assert both == pytest.approx([1.0 - 1.4, 0.2 - 1.0], abs=ROUNDING)
    assert rows({"elevation_rad": (-np.inf, 1.4)}, 0.5, 1.0, 0.0) == pytest.approx([-0.4])
    assert rows({"elevation_rad": (0.2, np.inf)}, 0.5, 1.0, 0.0) == pytest.approx([-0.8])
    assert rows({"elevation_rad": (-np.inf, np.inf)}, 0.5, 1.0, 0.0).size == 0
    assert rows({"attitude_w": (0.5, np.inf)}, 0.0, np.pi / 2, 0.0) == pytest.approx([-0.5])


ARCS = {
    "about 0": (-0.5, 0.5, {0.0, 0.49, -0.49}, {0.51, -0.51, 3.0, -3.0}),
    "through half a turn": (2.8, 3.6, {2.81, 3.1, -3.1, 3.59 - 2 * np.pi}, {2.79, 0.0, -2.6}),
    "through minus half a turn": (-3.6, -2.8, {-2.81, 3.1, -3.1}, {-2.79, 0.0, 2.6}),
    "one side": (0.5, np.inf, {0.51, 3.1}, {0.49, -3.1}),
}


@pytest.mark.parametrize("angle", [0, 2], ids=["azimuth", "spin"])
@pytest.mark.parametrize("name", ARCS)
def test_an_arc_of_an_angle_on_the_circle(name: str, angle: int) -> None:
    """With both sides it goes the short way round, through ±π too; rows are distances in rad."""
    low, high, inside, outside = ARCS[name]
    key = ANGLES[angle]
    for value in inside | outside:
        angles = [0.3, 0.7, 0.3]
        angles[angle] = value
        worst = float(rows({key: (low, high)}, *angles).max())
        assert (worst < 0) == (value in inside), value
        if np.isfinite(high):
            middle, half = (low + high) / 2, (high - low) / 2
            away = abs(np.angle(np.exp(1j * (value - middle))))
            assert worst == pytest.approx(away - half, abs=1e-12)


def test_a_reference_of_its_own() -> None:
    """The reference of these tests turns as `models.rotation` says, to rounding."""
    angles = np.array([0.4, 0.7, -1.1])
    R = body_to_world(*angles[:, None])[0]
    assert pytest.approx(R.as_matrix(), abs=1e-15) == matrix(WORLD_TO_BODY, angles).T
