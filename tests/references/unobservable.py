"""What no reading of a pen shows, derived on paper: changes of x = (q, q̇, q̈), no biases.

Under constant acceleration a change of the first state travels as
δφ(t) = δφ + δφ̇ t + δφ̈ t²/2, the same for θ, ψ and the tip p (δp, δv, δa). With five
degrees of freedom δψ = 0. The turn of the pen in the world is, with e_ρ = (cosφ, sinφ, 0),

    δα = e_z δφ - e_φ δθ + e_r δψ,    e_z × δα = e_ρ δθ + cosθ e_φ δψ

Held still (q̇ = q̈ = 0), an accelerometer at d from the tip (world axes) and a gyroscope
change by

    Bᵀ δf = δa + δα̈ × d + g e_z × δα,    Bᵀ δω = δα̇

and unobservable means zero at every t, power by power:

    accelerometer   t², t: δθ̈ = δψ̈ = 0, δθ̇ = δψ̇ = 0
                    1:     δa = -g e_ρ δθ - g cosθ e_φ δψ - (e_z × d) δφ̈       (1)
                    free: δp, δv, δφ, δφ̇, and δθ, δψ, δφ̈ with the δa of (1)
    two of them     (1) for both: (e_z × (d₂ - d₁)) δφ̈ = 0, so δφ̈ = 0
    gyroscope       e_z, e_φ, e_r are independent (cosθ ≠ 0): all rates and accelerations
                    of angles are 0; free: δp, δv, δa, δφ, δθ, δψ
    with the gyroscope, an accelerometer leaves δp, δv, δφ, and δθ, δψ with (1)
    writing area    δp = δv = δa = 0. Of (1) remains 0 = …: δθ = δψ = 0, except that a lone
                    accelerometer with e_z × d = u e_ρ + w cosθ e_φ leaves
                    δφ̈ = 1, δθ = -u/g, δψ = -w/g (on the axis u = 0, w = r); it
                    needs a spin, or w = 0
    camera          sees the tip (area) and the attitude, or the axis (5): nothing is left

Numbers of directions left, of 15 (5 degrees of freedom) and 18 (6), on the axis:

                               alone      area     camera
    accelerometer             10   11    2   3      0  0
    gyroscope                 11   12    2   3      0  0
    accelerometer, gyroscope   8    9    1   1      0  0
    two accelerometers         9   10    2   2      0  0

In motion, whatever it is, the readings

    f = B(φ, θ, ψ) (p̈ + d̈ + g e_z),    ω = (-cosθ ωφ, -ωθ, sinθ ωφ + ωψ) turned by ψ

do not change when p or v do, nor with all accelerometers when the world is turned about the
vertical: B(φ + ε) = B(φ) Rz(ε)ᵀ takes φ to φ + ε and a to Rz(ε) a, so

    accelerometers, with or without gyroscope   δp, δv, and δφ = 1 with δa = e_z × a     7
    gyroscope                                   δp, δv, δa, δφ                          10

A motion is called generic when nothing else is left. The area then says δp = δv = δa = 0,
which leaves δφ with a gyroscope, or where a is vertical. But it is a constant c, no reading:
‖p(t) - c‖ stays as it is when the whole motion is turned about the vertical through c, so

    accelerometers, area    δφ = 1, δp = e_z × (p - c), δv = e_z × v, δa = e_z × a    1
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
    "spin": (0, 5),
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
    x : the state at rest; with five degrees of freedom the spin is taken as zero
    mounting : (3,) of a lone accelerometer, body axes
    """
    n_q = len(x) // 3
    if tip_seen_by == "camera":
        return _columns(n_q, [])
    tilts = ["elevation", "spin"][: n_q - 4]
    tip = each(n_q, "p", "v") if tip_seen_by == "nothing" else []
    free = [*tip, change(n_q, azimuth=1)]
    if inertial == "gyro":
        free += each(n_q, "a") if tip_seen_by == "nothing" else []
        return _columns(n_q, free + [change(n_q, **{tilt: 1}) for tilt in tilts])
    if inertial != "accel+gyro":
        free.append(change(n_q, azimuth_rate=1))

    e_rho, e_phi, d = _horizontal_axes_and_place(x, mounting)
    cos = np.cos(x[4])
    turning = np.cross(UP, d)
    if tip_seen_by == "nothing":
        needed_a = {"elevation": -gravity * e_rho, "spin": -gravity * cos * e_phi}
        free += [change(n_q, **{tilt: 1}, a=needed_a[tilt]) for tilt in tilts]
        if inertial == "accel":
            free.append(change(n_q, azimuth_acceleration=1, a=-turning))
    elif inertial == "accel" and "spin" in tilts:
        u, w = turning @ e_rho, turning @ e_phi / cos
        tilted = {"elevation": -u / gravity, "spin": -w / gravity}
        free.append(change(n_q, azimuth_acceleration=1, **tilted))
    return _columns(n_q, free)


def _horizontal_axes_and_place(x: Array, mounting: Array) -> tuple[Array, Array, Array]:
    """Return e_ρ, e_φ and d = Bᵀ mounting, in world axes."""
    azimuth, elevation, spin = x[3], x[4], x[5] if len(x) == 18 else 0.0
    e_rho = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    e_phi = np.cross(UP, e_rho)
    e_r = np.cos(elevation) * e_rho + np.sin(elevation) * UP
    minus_e_theta = np.cross(e_phi, e_r)
    x_b = np.cos(spin) * minus_e_theta + np.sin(spin) * e_phi
    y_b = np.cos(spin) * e_phi - np.sin(spin) * minus_e_theta
    return e_rho, e_phi, x_b * mounting[0] + y_b * mounting[1] + e_r * mounting[2]


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
