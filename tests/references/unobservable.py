"""What no reading of [Pen]'s pen shows, derived on paper: changes of x = (q, q̇, q̈), no biases.

Five degrees of freedom, no spin; that of a free pen is `tests.references.unobservable_free`.

Under constant acceleration a change of the first state travels as
δφ(t) = δφ + δφ̇ t + δφ̈ t²/2, the same for θ and the tip p (δp, δv, δa). The turn of the
pen in the world is, with e_ρ = (cosφ, sinφ, 0),

    δα = e_z δφ - e_φ δθ,    e_z × δα = e_ρ δθ

Held still (q̇ = q̈ = 0), an accelerometer at d from the tip (world axes) and a gyroscope
change by

    Bᵀ δf = δa + δα̈ × d + g e_z × δα,    Bᵀ δω = δα̇

and unobservable means zero at every t, power by power:

    accelerometer   t², t: δθ̈ = 0, δθ̇ = 0
                    1:     δa = -g e_ρ δθ - (e_z × d) δφ̈                              (1)
                    free: δp, δv, δφ, δφ̇, and δθ, δφ̈ with the δa of (1)
    two of them     (1) for both: (e_z × (d₂ - d₁)) δφ̈ = 0, so δφ̈ = 0
    gyroscope       e_z, e_φ are independent: all rates and accelerations
                    of angles are 0; free: δp, δv, δa, δφ, δθ
    with the gyroscope, an accelerometer leaves δp, δv, δφ, and δθ with (1)
    writing area    δp = δv = δa = 0. Of (1) remains 0 = …: δθ = δφ̈ = 0 on the axis, where
                    e_z × d is along e_φ
    camera          sees the tip (area) and the axis: nothing is left

Numbers of directions left, of 15 (5 degrees of freedom) and 18 (the free pen), on the axis:

                               alone      area     camera
    accelerometer             10   11    2   3      0  0
    gyroscope                 11   12    2   3      0  0
    accelerometer, gyroscope   8    9    1   1      0  0
    two accelerometers         9   10    2   2      0  0

In motion, whatever it is, the readings

    f = B(φ, θ) (p̈ + d̈ + g e_z),    ω = (-cosθ ωφ, -ωθ, sinθ ωφ)

do not change when p or v do, nor with all accelerometers when the world is turned about the
vertical: B(φ + ε) = B(φ) Rz(ε)ᵀ takes φ to φ + ε and a to Rz(ε) a, so

    accelerometers, with or without gyroscope   δp, δv, and δφ = 1 with δa = e_z × a     7
    gyroscope                                   δp, δv, δa, δφ                          10

A motion is called generic when nothing else is left. The area then says δp = δv = δa = 0,
which leaves δφ with a gyroscope, or where a is vertical. But it is a constant c, no reading:
‖p(t) - c‖ stays as it is when the whole motion is turned about the vertical through c, so

    accelerometers, area    δφ = 1, δp = e_z × (p - c), δv = e_z × v, δa = e_z × a    1

(A free pen is told less in motion: its rates are the body's, and say nothing of a tilt.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
_PLACES: dict[str, tuple[int, int | slice]] = {
    "p": (0, slice(0, 3)),
    "v": (1, slice(0, 3)),
    "a": (2, slice(0, 3)),
    "azimuth": (0, 3),
    "elevation": (0, 4),
    "azimuth_rate": (1, 3),
    "azimuth_acceleration": (2, 3),
}
"""Part of the state → (order of its time derivative, degrees of freedom)."""


def change(n_q: int, **parts: float | Array) -> Array:
    """Return the state (3 n_q,) that is zero but for some parts."""
    state = np.zeros((3, n_q))
    for name, value in parts.items():
        state[_PLACES[name]] = value
    return state.ravel()


def each(n_q: int, *vectors: str) -> list[Array]:
    """Return the changes of every component of some vectors."""
    return [change(n_q, **{name: axis}) for name in vectors for axis in np.eye(3)]


def held_still(
    inertial: str, tip_seen_by: str, x: Array, mounting: Array, gravity: float = 9.81
) -> Array:
    """Return a basis (n_x, n) of what is unobservable at rest.

    Parameters
    ----------
    inertial : ``accel``, ``gyro``, ``accel+gyro`` or ``two accels``
    tip_seen_by : ``nothing``, ``area`` or ``camera``
    x : the state at rest
    mounting : (3,) of a lone accelerometer, body axes without spin; on the axis with an area
    """
    n_q = len(x) // 3
    if tip_seen_by == "camera":
        return _columns(n_q, [])
    tip = each(n_q, "p", "v") if tip_seen_by == "nothing" else []
    free = [*tip, change(n_q, azimuth=1)]
    if inertial == "gyro":
        free += each(n_q, "a") if tip_seen_by == "nothing" else []
        return _columns(n_q, [*free, change(n_q, elevation=1)])
    if inertial != "accel+gyro":
        free.append(change(n_q, azimuth_rate=1))
    if tip_seen_by == "nothing":
        e_rho, d = _horizontal_axis_and_place(x, mounting)
        free.append(change(n_q, elevation=1, a=-gravity * e_rho))
        if inertial == "accel":
            free.append(change(n_q, azimuth_acceleration=1, a=-np.cross(UP, d)))
    return _columns(n_q, free)


def _horizontal_axis_and_place(x: Array, mounting: Array) -> tuple[Array, Array]:
    """Return e_ρ and d = Bᵀ mounting, in world axes."""
    azimuth, elevation = x[3], x[4]
    e_rho = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    e_phi = np.cross(UP, e_rho)
    e_r = np.cos(elevation) * e_rho + np.sin(elevation) * UP
    x_b = np.cross(e_phi, e_r)
    return e_rho, x_b * mounting[0] + e_phi * mounting[1] + e_r * mounting[2]


def in_motion(inertial: str, tip_seen_by: str, x: Array, centre: Array) -> Array:
    """Return a basis (n_x, n) of what is unobservable in a generic motion from state x on.

    Parameters
    ----------
    inertial, tip_seen_by : see `held_still`
    centre : (3,) c of the area
    """
    n_q = len(x) // 3
    p, v, a = (x[i * n_q : i * n_q + 3] for i in range(3))
    turned_a = np.cross(UP, a)
    if tip_seen_by == "camera":
        return _columns(n_q, [])
    if inertial == "gyro":
        tip = each(n_q, "p", "v", "a") if tip_seen_by == "nothing" else []
        return _columns(n_q, [*tip, change(n_q, azimuth=1)])
    if tip_seen_by == "nothing":
        return _columns(n_q, [*each(n_q, "p", "v"), change(n_q, azimuth=1, a=turned_a)])
    if not turned_a.any():
        return _columns(n_q, [change(n_q, azimuth=1)])
    turned = {"p": np.cross(UP, p - centre), "v": np.cross(UP, v), "a": turned_a}
    return _columns(n_q, [change(n_q, azimuth=1, **turned)])


def _columns(n_q: int, changes: list[Array]) -> Array:
    return np.array(changes).reshape(-1, 3 * n_q).T
