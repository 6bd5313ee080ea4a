"""The pen as a rigid body with its sensors.

With six degrees of freedom it turns freely, `models.free_pen`:

    x = (p, σ, v, ω, a, α, biases)

p is the tip, σ its attitude (three numbers without a singularity), ω and α the rate of its body
and the derivative. With five it cannot spin about its axis, and keeps the coordinates of [Pen],
`models.euler_pen`: x = (q, q̇, q̈, biases), q = (X, Y, Z, φ, θ).

What drives it is data, `models.motion`.

References
----------
[Pen] equations (1)-(3), with E1 corrected; spin and biases are additions.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from models import attitude
from models.arrays import Array, arrays_within, fixed
from models.body_model import Kinematics, body_model, check_rest, choose_sensors, rest_of
from models.content import ByContent
from models.euler_pen import euler_body, euler_kinematics, tip_std
from models.free_kinematics import free_kinematics
from models.free_pen import N_FREE, Frame, FreeBody
from models.heading import free_heading_symmetry, heading_symmetry
from models.kinematics import Body
from models.level import UP, up_direction
from models.names import several
from models.paper import above_paper
from models.pen_config import PenConfig
from models.pen_file import AnyPen, as_pen
from models.printed import PrintedBody
from models.sensor_kinds.reading import MovingBody
from models.sensor_kinds.writing_area import WritingArea
from models.state_space import StateSpaceModel


def pen_model(
    pen: AnyPen,
    sensors: Iterable[str] | None = None,
    *,
    writing_area: bool = True,
    rest: bool = True,
) -> StateSpaceModel:
    """Return the state-space model of a pen with some or all of its sensors.

    Pens that say the same have one model: its arrays cannot be written to, `replace` gives another.

    Parameters
    ----------
    pen : a pen, the name of a bundled one, or the path of a pen file
    sensors : names from the pen file, in the order to stack them; None takes all
    writing_area : adds the pen's writing area where none of the sensors sees a position;
        False takes the sensors as they are, so position and tilt may drift without bound
    rest : adds the pen's sensor of rest, where its file has one, to a gyroscope; False takes
        the sensors as they are, so a still pen gains false confidence

    Raises
    ------
    InputError
        If a sensor or a bound is unknown, or rest has no gyroscope; the message lists what is.
    """
    names = None if sensors is None else several(sensors)
    return _model_of(ByContent(as_pen(pen)), names, bool(writing_area), bool(rest))


@lru_cache(maxsize=16)
def _model_of(
    pen: ByContent[PenConfig], sensors: tuple[str, ...] | None, writing_area: bool, rest: bool
) -> StateSpaceModel:
    """Return the one model of pens that say the same: what is made of it is found again, too."""
    config = pen.config
    chosen = choose_sensors(config.sensors, sensors, f"pen {config.name}")
    has_camera = any(sensor.sees_pose for sensor in chosen.values())
    if writing_area and not any(sensor.sees_position for sensor in chosen.values()):
        chosen |= _writing_area(config)
    if rest:
        chosen |= rest_of(config.sensors, chosen)
    check_rest(chosen, f"pen {config.name}")
    is_free = config.degrees_of_freedom == 6
    sees_north = any(sensor.sees_north for sensor in chosen.values())
    frame = attitude.fixed if sees_north else attitude.heading
    kinematics, body = pen_kinematics(config, has_camera=has_camera, frame=frame)
    up = up_direction(config.level_rad)
    moving = MovingBody(body, config.gravity_m_s2, has_spin=is_free, up=up)
    name = f"{config.name}, {config.degrees_of_freedom} degrees of freedom"
    model = body_model(name, kinematics, moving, chosen)
    n_x, centre = model.n_x, _centre(chosen.values())
    symmetries: tuple[ca.Function, ...] = ()
    if is_free:
        symmetries = (free_heading_symmetry(n_x, centre_m=centre, up=up),)
    elif up == UP:  # a pen without spin, turned about a leaning axis, would have to spin
        symmetries = (heading_symmetry(config.degrees_of_freedom, n_x, centre_m=centre),)
    model = model.replace(
        symmetries=symmetries,
        reach=np.array([config.reach_m] * 3 + [np.inf] * (n_x - 3)),
    )
    model = model.bounded(**config.bounds)
    if config.paper is not None:
        model = above_paper(model, config.paper, sensors=config.sensors)
    for array in arrays_within(model):
        fixed(array)
    return model


def pen_kinematics(
    config: PenConfig, *, has_camera: bool, frame: Frame = attitude.heading
) -> tuple[Kinematics, Body]:
    """Return the states of a pen without its sensors, and its body in their symbols.

    Parameters
    ----------
    has_camera : see `models.euler_pen.tip_std`
    frame : of tilts, for a pen that turns freely; see `models.free_pen`
    """
    if config.degrees_of_freedom == 6:
        return _free_pen(config, has_camera, frame)
    return _paper_pen(config, has_camera)


def _free_pen(config: PenConfig, has_camera: bool, frame: Frame) -> tuple[Kinematics, Body]:
    x = ca.SX.sym("x", N_FREE)
    first = tip_std(config.motion, config.prior, has_camera=has_camera)
    return free_kinematics(x, config.motion, config.prior, first, frame=frame), FreeBody(x)


def _paper_pen(config: PenConfig, has_camera: bool) -> tuple[Kinematics, Body]:
    n_q = config.degrees_of_freedom
    q, q_dot, q_ddot = (ca.SX.sym(symbol, n_q) for symbol in ("q", "q_dot", "q_ddot"))
    kinematics = euler_kinematics(
        q, q_dot, q_ddot, config.motion, config.prior, has_camera=has_camera
    )
    rigid = euler_body(q, q_dot, q_ddot, fixed_spin_rad=config.fixed_spin_rad)
    errors = config.printed_errors
    return kinematics, PrintedBody(rigid, errors) if errors else rigid


def _centre(sensors: Iterable[Any]) -> Array | None:
    """Return the centre (3,) of the writing area, None without one."""
    for sensor in sensors:
        if sensor.place_m is not None:
            return np.array(sensor.place_m)
    return None


def _writing_area(config: PenConfig) -> dict[str, Any]:
    """Return the pen's writing area by name, or one around its prior tip where it has none."""
    for name, sensor in config.sensors.items():
        if sensor.place_m is not None:
            return {name: sensor}
    name = "area"
    while name in config.sensors:
        name = f"writing_{name}"
    return {name: WritingArea(centre_m=config.prior.tip_m)}
