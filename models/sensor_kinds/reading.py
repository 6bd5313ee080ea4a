"""What a sensor on a moving body reads, in symbols of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from models.arrays import Array
from models.kinematics import Body
from models.level import UP, Vector3
from models.sensor_model import RestRule


@dataclass(frozen=True)
class MovingBody:
    """A body in a field of gravity, whether it may spin about its axis, and which way is up."""

    rigid: Body
    gravity_m_s2: float
    has_spin: bool
    up: Vector3 = UP


@dataclass(frozen=True)
class SymbolicReading:
    """A sensor's reading as an expression of the state.

    Parameters
    ----------
    h : (n_y,) expression of a reading without noise
    seen : expression that is negative where there is no reading; None reads everywhere
    noise_std : (n_r,)
    row_units : (n_r,) units of the residual's rows; those of the axes where it is None
    residual : takes y (n_y,) and returns (n_r,); y - h where it is None
    """

    h: ca.SX
    noise_std: Array
    residual: Callable[[ca.SX], ca.SX] | None = None
    constant_reading: Array | None = None
    reading_limit: float | None = None
    resolution: float = 0.0
    touched_height: float | None = None
    rest: RestRule | None = None
    row_units: tuple[str, ...] | None = None
    seen: ca.SX | None = None


@dataclass(frozen=True)
class BiasStates:
    """The bias states that a sensor asks for: names, unit, initial mean and std, walk density."""

    names: tuple[str, ...] = ()
    unit: str = ""
    mean: tuple[float, ...] = ()
    std: float = 0.0
    walk: float = 0.0
