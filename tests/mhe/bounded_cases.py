"""Models with constraints of every sort, as data: what the windows of `bounded_windows` are of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmark.bodies import BODIES
from models.gaussian import GaussianState
from models.paper import Paper
from models.pen import pen_model
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable, turntable_model
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system, coupled_system
from tests.mhe import pendulum


@dataclass(frozen=True)
class BoundedCase:
    """A model, what bounds it, and how its windows are drawn.

    Parameters
    ----------
    free : the model without constraints
    bounded : the same with them
    row : of `mhe.constraint_rows` that windows are placed by
    spread : part of the prior's standard deviations that the truth starts within
    step_s : mean interval between stages
    slow : sensors that read at every third stage only
    """

    free: StateSpaceModel
    bounded: StateSpaceModel
    row: int = 0
    spread: float = 1.0
    step_s: float = 0.01
    slow: tuple[str, ...] = ()


def _pen15() -> BoundedCase:
    """The pen of the suite speed, by accelerometer and gyroscope: its tip within 2 mm of paper."""
    free = BODIES["pen15"]().model()
    return BoundedCase(free, free.bounded(tip_z_m=(0.0, 0.002)), spread=0.2)


def _dpoint() -> BoundedCase:
    """The D-POINT stylus on its paper: a slow camera, and held to the paper while it touches."""
    pen, sensors = load_pen("dpoint"), ("accel", "gyro", "camera", "contact")
    paper = Paper(height_m=0.0, touch_tolerance_m=2e-4)
    bounded = pen_model(pen.model_copy(update={"paper": paper}), sensors)
    free = pen_model(pen, sensors)
    return BoundedCase(free, bounded, spread=0.05, slow=("camera",))


def _turntable() -> BoundedCase:
    """A turntable with a stop, by accelerometer and gyroscope."""
    free = turntable_model(paper_turntable())
    bounded = free.bounded(tilt_phi_rad=(-np.inf, 0.5))
    return BoundedCase(free, bounded, spread=0.5, step_s=0.1)


def _two_axes() -> BoundedCase:
    """A linear system with two bounds and an affine inequality."""
    free = constant_acceleration_system(2).model
    bounded = free.bounded(s0_m=(-np.inf, 0.3), s1_m=(-0.4, np.inf))
    bounded = bounded.constrained(lambda x: x[0] + x[1] - 0.5)
    return BoundedCase(free, bounded, row=1, step_s=0.1)


def _coupled() -> BoundedCase:
    """A linear system in which everything moves everything, with bounds on two states."""
    free = coupled_system(3).model
    bounded = free.bounded(s0_m=(-1.0, 0.2), s2_m=(-np.inf, 0.4))
    return BoundedCase(free, bounded, row=1, step_s=0.1)


def _circle() -> BoundedCase:
    """A linear system whose position stays within a circle: a curved inequality."""
    free = constant_acceleration_system(2).model
    bounded = free.constrained(lambda x: x[0] ** 2 + x[1] ** 2 - 1.0)
    return BoundedCase(free, bounded, spread=0.1, step_s=0.03)


def _pen_in_a_circle() -> BoundedCase:
    """A pen above its desk whose tip stays within a disc of 30 cm."""
    free = pen_model(pens.pen_config())
    bounded = free.bounded(tip_z_m=(0.0, np.inf)).constrained(
        lambda x: (x[0] ** 2 + x[1] ** 2) / 0.3**2 - 1.0
    )
    return BoundedCase(free, bounded, row=1, spread=0.2, step_s=0.005, slow=("camera",))


def _pendulum() -> BoundedCase:
    """A transition that is nonlinear in state and noise, and a wall."""
    prior = GaussianState(pendulum.PRIOR_MEAN, np.diag((0.3 * pendulum.PRIOR_STD) ** 2))
    free = pendulum.model().replace(prior=prior)
    return BoundedCase(free, free.bounded(s0_m=(-np.inf, 0.4)), step_s=0.02)


CASES: Mapping[str, Callable[[], BoundedCase]] = {
    "pen15": _pen15,
    "dpoint": _dpoint,
    "turntable": _turntable,
    "two axes": _two_axes,
    "coupled": _coupled,
    "circle": _circle,
    "pen in a circle": _pen_in_a_circle,
    "pendulum": _pendulum,
}


@cache
def bounded_case(name: str) -> BoundedCase:
    """Return a case by its name."""
    return CASES[name]()
