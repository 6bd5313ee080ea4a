"""What no reading of a free pen shows, derived on paper, in whole changes of its motion.

δϑ is a turn of the pen in the world, B = Rᵀ world to body, f the specific force, ω and α the
body's rate and its derivative, b_a and b_g constant biases in body axes. δp, δv, δa are whole
changes of the tip's motion.

Without noise a and α are constant, R(t) = R₀ E(t), where E depends on ω and α alone.

Held still (v = ω = a = α = 0, so E = I), with changes of rates as vectors in the world, δΩ = R δω,
δA = R δα, and an accelerometer at d from the tip (world axes),

    δϑ(t) = δϑ + δΩ t + δA t²/2
    R δf = δa + g e_z × δϑ(t) + δA × d + R δb_a,      R δω_read = δΩ + δA t + R δb_g

and unobservable means zero at every t, power by power:

    accelerometer   t², t: e_z × δA = e_z × δΩ = 0, so δA = κ e_z, δΩ = μ e_z
                    1:     δa + R δb_a = -g e_z × δϑ - κ e_z × d                       (1)
                    free: δp, δv, δϑ, κ, μ, δb_a with the δa of (1)
    two of them     (1) for both: κ e_z × (d₂ - d₁) = 0, so κ = 0
    gyroscope       δA = 0, δb_g = -Rᵀ δΩ; free: δp, δv, δa, δϑ, δΩ (without a bias δΩ = 0)
    both            free: δp, δv, δϑ, δb_a with (1), κ = 0, and with a bias μ with
                    δb_g = -μ Rᵀ e_z: at rest a rate about the vertical is not told from it
    writing area    δp = δv = δa = 0. Of (1) remains R δb_a = -g e_z × δϑ - κ e_z × d: a
                    tilt (or κ) with an accelerometer's bias; without one e_z × (g δϑ + κ d) = 0,
                    so κ = 1 with δϑ = -(d without its vertical part) / g, and δϑ = e_z
    camera          sees tip and attitude: nothing is left

In motion, whatever it is, R(t)ᵀ (a + g e_z) stays as it is when R₀ and a + g e_z are turned
alike, and so do rates and levers, as these are the body's:

    accelerometers, with or without gyroscope   δp, δv, and δϑ with δa = δϑ × (a + g e_z)   9
    gyroscope                                   δp, δv, δa, δϑ                             12

A motion is called generic when nothing else is left. No motion tells a gyroscope anything of the
attitude. The area says δp = δv = δa = 0: that leaves all of δϑ with a gyroscope, and with
accelerometers a turn about a + g e_z (while a is constant: a jerk would show it). But it is a
constant c, no reading: ‖p(t) - c‖ stays as it is when the whole motion is turned about the
vertical through c, so that with accelerometers there is another,

    δϑ = e_z, δp = e_z × (p - c), δv = e_z × v, δa = e_z × a

or, where v and a are vertical, the turn about the vertical alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
N_FREE = 18
P, THETA, V, OMEGA, A, ALPHA = (slice(3 * i, 3 * i + 3) for i in range(6))
AXES = np.eye(3)
GRAVITY = 9.81


class Changes:
    """Changes of a state (n_x,): δp, δϑ, δv, δΩ, δa, δA in the world, biases in body axes.

    Parameters
    ----------
    x : (n_x,) a free pen, biases behind its 18 states
    biases : names of the sensors that they are of, three each: ``accel``, ``gyro``
    """

    def __init__(self, x: Array, biases: tuple[str, ...] = ()) -> None:
        self.x, self.R = x, Rotation.from_mrp(x[THETA]).as_matrix()
        self.part = {"p": P, "turn": THETA, "v": V, "rate": OMEGA, "a": A, "acceleration": ALPHA}
        for i, name in enumerate(biases):
            self.part[name] = slice(N_FREE + 3 * i, N_FREE + 3 * i + 3)

    def of(self, **changes: Array) -> Array:
        """Return the vector (n_x,) that is zero but for some changes."""
        d = np.zeros(len(self.x))
        for name, change in changes.items():
            d[self.part[name]] = change
        return d

    def each(self, *names: str) -> list[Array]:
        """Return those of every component of some changes."""
        return [self.of(**{name: axis}) for name in names for axis in AXES]


def held_still(
    inertial: str,
    tip_seen_by: str,
    x: Array,
    mounting: Array,
    biases: tuple[str, ...] = (),
) -> Array:
    """Return a basis (n_x, n) of what is unobservable at rest.

    Parameters
    ----------
    inertial : ``accel``, ``gyro``, ``accel+gyro`` or ``two accels``
    tip_seen_by : ``nothing``, ``area`` or ``camera``
    x : the state at rest
    mounting : (3,) of a lone accelerometer, body axes
    biases : of ``accel``, ``gyro`` those that have one, in the state's order
    """
    at = Changes(x, biases)
    if tip_seen_by == "camera":
        return _columns(x, [])
    is_open = tip_seen_by == "nothing"
    free = at.each("p", "v") if is_open else []
    if inertial == "gyro":
        free += at.each("a", "turn") if is_open else at.each("turn")
        around = AXES if "gyro" in biases else []
        return _columns(x, free + [at.of(rate=i, gyro=-at.R.T @ i) for i in around])

    free.append(at.of(turn=UP))
    if inertial != "accel+gyro":
        free.append(at.of(rate=UP))
    elif "gyro" in biases:
        free.append(at.of(rate=UP, gyro=-at.R.T @ UP))
    # What the tilts, κ and a bias ask of the specific force in the world, -R δf without δa.
    tilts = [{"turn": axis} for axis in AXES[:2]]
    asked = [-GRAVITY * np.cross(UP, axis) for axis in AXES[:2]]
    if inertial == "accel":
        tilts.append({"acceleration": UP})
        asked.append(-np.cross(UP, at.R @ mounting))
    if is_open:
        free += [at.of(**tilt, a=a) for tilt, a in zip(tilts, asked, strict=True)]
        if "accel" in biases:
            free += [at.of(accel=axis, a=-at.R @ axis) for axis in AXES]
    elif "accel" in biases:
        free += [at.of(**tilt, accel=at.R.T @ a) for tilt, a in zip(tilts, asked, strict=True)]
    elif inertial == "accel":
        level = at.R @ mounting * [1.0, 1.0, 0.0]
        free.append(at.of(acceleration=UP, turn=-level / GRAVITY))
    return _columns(x, free)


def in_motion(inertial: str, tip_seen_by: str, x: Array, centre: Array) -> Array:
    """Return a basis (n_x, n) of what is unobservable in a generic motion from state x on.

    Parameters
    ----------
    inertial, tip_seen_by : see `held_still`
    centre : (3,) c of the area
    """
    at, is_open = Changes(x), tip_seen_by == "nothing"
    if tip_seen_by == "camera":
        return _columns(x, [])
    if inertial == "gyro":
        return _columns(x, at.each(*(("p", "v", "a", "turn") if is_open else ("turn",))))
    p, v, a = x[P], x[V], x[A]
    force = a + GRAVITY * UP
    if is_open:
        turned = [at.of(turn=axis, a=np.cross(axis, force)) for axis in AXES]
        return _columns(x, at.each("p", "v") + turned)
    if not (a[:2].any() or v[:2].any()):
        return _columns(x, [at.of(turn=UP)])
    heading = at.of(turn=UP, p=np.cross(UP, p - centre), v=np.cross(UP, v), a=np.cross(UP, a))
    return _columns(x, [at.of(turn=force), heading])


def _columns(x: Array, changes: list[Array]) -> Array:
    return np.array(changes).reshape(-1, len(x)).T
