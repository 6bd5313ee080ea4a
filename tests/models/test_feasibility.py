"""Constraints that no state meets are refused when the model is made, with their rows."""

from __future__ import annotations

import re
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from models.errors import InputError
from models.state_space import StateSpaceModel
from tests.linear_models import coupled_system

MODEL = coupled_system(4).model
LOWER_HALF = MODEL.bounded(s0_m=(-np.inf, 0.0))
Inequality = Callable[[ca.SX], ca.SX]

IMPOSSIBLE: dict[str, tuple[StateSpaceModel, Inequality, str]] = {
    "a row against a bound": (
        LOWER_HALF,
        lambda x: 1 - x[0],
        "row 1 of the inequality ((1-s0_m) <= 0) and the bound on s0_m (-inf to 0), expected",
    ),
    "a row against a bound, others idle": (
        LOWER_HALF.bounded(s1_m=(0.0, 1.0)),
        lambda x: ca.vertcat(x[1] - 5, x[0] + x[2], 2 - x[0]),
        "row 3 of the inequality ((2-s0_m) <= 0) and the bound on s0_m (-inf to 0), expected",
    ),
    "a row against two bounds": (
        MODEL.bounded(s0_m=(0.0, 1.0), s1_m=(0.0, 1.0), s2_m=(0.0, 1.0)),
        lambda x: 2.5 - x[0] - x[1],
        "and the bound on s0_m (0 to 1) and the bound on s1_m (0 to 1), expected",
    ),
    "two rows": (
        MODEL,
        lambda x: ca.vertcat(x[1], x[0] + x[1] - 1, x[0] ** 2, 3 - x[0] - x[1]),
        "row 2 of the inequality (((s0_m+s1_m)-1) <= 0) and row 4 of the inequality",
    ),
    "a row of an earlier inequality": (
        MODEL.constrained(lambda x: ca.vertcat(x[1], x[0])),
        lambda x: 1 - x[0],
        "row 2 of the inequality (s0_m <= 0) and row 3 of the inequality ((1-s0_m) <= 0)",
    ),
    "a constant": (MODEL, lambda x: ca.SX(1), "row 1 of the inequality (1 <= 0), expected"),
    "a miss in small numbers": (LOWER_HALF, lambda x: 1e-9 * (1 - x[0]), "row 1 of the inequality"),
    "a narrow miss, in large numbers": (
        LOWER_HALF,
        lambda x: 1e6 * (1e-5 - x[0]),
        "row 1 of the inequality",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_no_state_meets_is_refused(name: str) -> None:
    model, inequality, demands = IMPOSSIBLE[name]
    with pytest.raises(InputError, match=f"^model linear: no state meets .*{re.escape(demands)}"):
        model.constrained(inequality)


def test_bounds_after_the_inequality_are_refused_alike() -> None:
    model = MODEL.constrained(lambda x: 1 - x[0])
    with pytest.raises(InputError, match=r"row 1 .* and the bound on s0_m \(-inf to 0\)"):
        model.bounded(s0_m=(-np.inf, 0.0))
    assert model.bounded(s0_m=(-np.inf, 1.5)).upper[0] == 1.5


POSSIBLE: dict[str, Inequality] = {
    "one point": lambda x: ca.vertcat(x[0], -x[0]),
    "a row that others make redundant": lambda x: ca.vertcat(x[0] - 1, x[0] - 2),
    "a constant": lambda x: ca.SX(-1),
    "nothing": lambda x: ca.SX(0, 1),
    "affine, written with products": lambda x: ca.mtimes(ca.DM([[2, 1, 0, 0]]), x[:4]) / 3 - 1,
}


@pytest.mark.parametrize("name", POSSIBLE)
def test_what_some_state_meets_is_accepted(name: str) -> None:
    model = LOWER_HALF.constrained(POSSIBLE[name])
    x = ca.DM.zeros(MODEL.n_x)
    assert model.inequality.numel_out(0) == POSSIBLE[name](x).numel()
    assert (np.asarray(model.inequality(x)) <= 0).all()


NOT_AFFINE: dict[str, Inequality] = {
    "a square": lambda x: 1 + x[0] ** 2,
    "a product": lambda x: x[0] * x[1] + 1,
    "a step, of constant Jacobian": lambda x: ca.floor(x[0]) + 1,
    "a condition, of constant Jacobian": lambda x: ca.if_else(x[0] < -1, -1, 1),
    "a modulus": lambda x: 1 - ca.fabs(x[0]),
    "a division by zero": lambda x: x[0] / ca.SX(0),
}


@pytest.mark.parametrize("name", NOT_AFFINE)
def test_what_is_not_affine_is_left_to_the_solver(name: str) -> None:
    model = LOWER_HALF.constrained(NOT_AFFINE[name])
    assert model.inequality.numel_out(0) == 1


@pytest.mark.parametrize("seed", range(20))
def test_against_a_search_in_the_plane(seed: int) -> None:
    """Random half-planes in a box: a fine grid finds a state, or the model is refused."""
    rng = np.random.default_rng(seed)
    angles, offsets = rng.uniform(0, 2 * np.pi, 4), rng.uniform(-0.2, 0.9, 4)
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    side = np.linspace(-1, 1, 401)
    grid = np.stack(np.meshgrid(side, side)).reshape(2, -1)
    slack = (offsets[:, None] + normals @ grid).max(axis=0).min()
    # A margin of a grid's step: nearer than that the grid cannot tell.
    assert abs(slack) > np.sqrt(2) * (side[1] - side[0])
    box = MODEL.bounded(s0_m=(-1.0, 1.0), s1_m=(-1.0, 1.0))

    def half_planes(x: ca.SX) -> ca.SX:
        return ca.DM(offsets) + ca.mtimes(ca.DM(normals), x[:2])

    if slack < 0:
        assert box.constrained(half_planes).inequality.numel_out(0) == 4
    else:
        with pytest.raises(InputError, match="no state meets row"):
            box.constrained(half_planes)
