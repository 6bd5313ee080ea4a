"""Symmetries of a model: changes of the state that no sensor of it can show.

A symmetry is a flow s(x, α) with s(x, 0) = x. It holds for a choice of sensors if,
along a motion,

    h(s(x, α)) = h(x)                     for sensors that measure,
    ‖residual(s(x, α))‖ = ‖residual(x)‖   for those with a constant reading,
    f(s(x, α), 0, Δt) = s(f(x, 0, Δt), α)

The second line is what a linearised Gramian misses: a constant reading is a prior,
and one that is the same from all sides says nothing of the side.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from models.arrays import Array
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel

ANGLE = 0.5
"""The flow's parameter at which a symmetry is tried: far enough that nothing holds by chance."""

TOLERANCE = 1e-9
"""In standard deviations."""


@lru_cache(maxsize=16)
def direction_function(model: StateSpaceModel, symmetry: ca.Function) -> ca.Function:
    """Return x (n_x,) -> ds/dα (n_x,) at α = 0, a tangent vector at x."""
    at, a = ca.SX.sym("x", model.n_x), ca.SX.sym("a")
    slope = ca.jacobian(model.difference(symmetry(at, a), at), a)
    return ca.Function("slope", [at], [ca.densify(ca.substitute(slope, a, 0))])


def direction(model: StateSpaceModel, symmetry: ca.Function, x: Array) -> Array:
    """Return ds/dα (n_x,) at α = 0, a tangent vector at x."""
    along: Array = direction_function(model, symmetry)(x).full().ravel()
    return along


def holds(model: StateSpaceModel, symmetry: ca.Function, states: Array, dt: float) -> bool:
    """Whether a symmetry holds at all of some states (n, n_x), for steps of `dt`."""
    no_noise = np.zeros(model.n_w)
    for x in states:
        turned = symmetry(x, ANGLE)
        if not all(_is_blind(sensor, x, turned) for sensor in model.sensors):
            return False
        then = model.f(turned, no_noise, dt)
        expected = symmetry(model.f(x, no_noise, dt), ANGLE)
        away = model.difference(then, expected).full().ravel()
        if (np.abs(away) > TOLERANCE * model.prior.std).any():
            return False
    return True


def _is_blind(sensor: SensorModel, x: Array, turned: ca.DM) -> bool:
    if sensor.constant_reading is None:
        seen = sensor.residual(sensor.h(x), turned).full().ravel() / sensor.noise_std
        return bool((np.abs(seen) < TOLERANCE).all())
    before, after = (
        np.linalg.norm(sensor.residual(sensor.constant_reading, at).full().ravel())
        for at in (x, turned)
    )
    return bool(abs(after - before) < TOLERANCE * sensor.noise_std.min())
