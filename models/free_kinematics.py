"""States, prior and readings for people of a pen that turns freely, see `models.free_pen`."""

from __future__ import annotations

import casadi as ca
import numpy as np

from models import attitude, free_pen
from models.arrays import Array
from models.body_model import Kinematics
from models.free_pen import ALPHA, N_FREE, OMEGA, SIGMA, STATES, TIP, A, Frame, V
from models.motion import Motion
from models.outputs import UNIFORM_ANGLE_STD_RAD, Outputs, TangentNames
from models.pen_config import Prior
from models.rotation import about_z, cross_matrix, vee, world_to_body

ANGLES = ("azimuth_rad", "elevation_rad", "spin_rad")
QUATERNION = tuple(f"attitude_{axis}" for axis in "wxyz")
"""Body to world, w ≥ 0."""

_AXES = ("about world x", "about world y", "about the vertical")


def free_kinematics(
    x: ca.SX, motion: Motion, prior: Prior, tip_std: tuple[float, float], *, frame: Frame
) -> Kinematics:
    """Return states and motion of a pen with six degrees of freedom.

    Parameters
    ----------
    x : symbols (18,)
    tip_std : of the tip's first velocity (m/s) and acceleration (m/s²)
    frame : of tilts, see `models.free_pen`
    """
    tip, turning = motion.tip.built(), motion.attitude.built()
    names, units = zip(*STATES, strict=True)
    mean, covariance = _prior(prior, tip_std, frame)
    return Kinematics(
        x=x,
        names=names,
        units=units,
        step=lambda x, w, dt: free_pen.step(x, w, dt, tip, turning, centre_m=motion.tip.centre_m),
        retract=lambda x, d: free_pen.retract(x, d, frame=frame),
        difference=lambda to, of: free_pen.difference(to, of, frame=frame),
        mean=mean,
        covariance=covariance,
        regularity=attitude.level_part(x[SIGMA]),
        outputs=_outputs(x),
        tangent=_tangent_names(x, frame),
    )


def _outputs(x: ca.SX) -> Outputs:
    """The tip, angles and quaternion in place of σ, and the rates."""
    of_state = {name: (unit, x[i]) for i, (name, unit) in enumerate(STATES)}
    angles = attitude.pen_angles(x[SIGMA])
    shown = {name: ("rad", angles[i]) for i, name in enumerate(ANGLES)}
    quaternion = attitude.quaternion(x[SIGMA])
    shown |= {name: ("1", quaternion[i]) for i, name in enumerate(QUATERNION)}
    names = [name for name, _ in STATES]
    table = {name: of_state[name] for name in names[TIP]} | shown
    for part in (V, OMEGA, A, ALPHA):
        table |= {name: of_state[name] for name in names[part]}
    units, values = zip(*table.values(), strict=True)
    wrapped = tuple(name in ("azimuth_rad", "spin_rad") for name in table)
    function = ca.Function("outputs", [x], [ca.vertcat(*values)], ["x"], ["outputs"])
    return Outputs(tuple(table), units, function, wrapped)


def _tangent_names(x: ca.SX, frame: Frame) -> TangentNames:
    """Turns, rates and accelerations in world axes, and whole changes of v and a.

    The tangent vector leaves out what turns with the attitude: δv = d_v + N d_θ × v.
    """
    names, units = (list(column) for column in zip(*STATES, strict=True))
    R, T = attitude.body_to_world(x[SIGMA]), ca.SX.eye(N_FREE)
    for part, word, unit in (
        (SIGMA, "turning", "rad"),
        (OMEGA, "rate of turning", "rad/s"),
        (ALPHA, "angular acceleration", "rad/s²"),
    ):
        names[part] = [f"{word} {axis}" for axis in _AXES]
        units[part] = [unit] * 3
    N = frame(x[SIGMA])
    T[SIGMA, SIGMA] = N
    T[OMEGA, OMEGA] = T[ALPHA, ALPHA] = R
    for part in (V, A):
        T[part, SIGMA] = -cross_matrix(x[part]) @ N
    return TangentNames(tuple(names), tuple(units), ca.Function("whole", [x], [ca.densify(T)]))


def attitude_of(azimuth_rad: float, elevation_rad: float, spin_rad: float) -> Array:
    """Return σ (3,) of a pen's angles."""
    B = world_to_body(ca.SX(azimuth_rad), ca.SX(elevation_rad), ca.SX(spin_rad))
    sigma: Array = ca.evalf(attitude.from_matrix(B.T)).full().ravel()
    return sigma


def _prior(prior: Prior, tip_std: tuple[float, float], frame: Frame) -> tuple[Array, Array]:
    """Return mean (18,) and covariance (18, 18) of the states."""
    mean, covariance = np.zeros(N_FREE), np.zeros((N_FREE, N_FREE))
    mean[TIP] = prior.tip_m
    mean[SIGMA] = attitude_of(prior.azimuth_rad, prior.elevation_rad, prior.spin_rad)
    for part, std in (
        (TIP, prior.tip_std_m),
        (V, tip_std[0]),
        (OMEGA, prior.angle_rate_std_rad_s),
        (A, tip_std[1]),
        (ALPHA, prior.angle_acceleration_std_rad_s2),
    ):
        covariance[part, part] = std**2 * np.eye(3)
    R = ca.evalf(attitude.body_to_world(ca.SX(mean[SIGMA]))).full()
    M = ca.evalf(frame(ca.SX(mean[SIGMA]))).full().T @ R  # body to the tangent space
    covariance[SIGMA, SIGMA] = M @ attitude_covariance(prior) @ M.T
    return mean, covariance


def attitude_covariance(prior: Prior) -> Array:
    """Return the covariance (3, 3) of a turn in body axes from standard deviations of the angles.

    P = J diag(σ²) Jᵀ, where J turns rates of the angles into the body's rate. About the
    horizontal body axis that moves the azimuth J is cosθ and vanishes where the pen stands
    upright: where nothing is known of the azimuth, the tilt about it is known no better than
    that about the other, so an upright pen's tilt is isotropic.
    """
    angles, rates = ca.SX.sym("angles", 3), ca.SX.sym("rates", 3)
    B = world_to_body(angles[0], angles[1], angles[2])
    turned = vee(B @ ca.reshape(ca.jtimes(ca.vec(B.T), angles, rates), 3, 3))
    jacobian = ca.Function("J", [angles], [ca.jacobian(turned, rates)])
    J = jacobian([0.0, prior.elevation_rad, 0.0]).full()
    std = np.array([prior.azimuth_std_rad, prior.elevation_std_rad, prior.spin_std_rad])
    P = J @ np.diag(std**2) @ J.T
    unknown = min(prior.azimuth_std_rad / UNIFORM_ANGLE_STD_RAD, 1.0)
    P[0, 0] = max(P[0, 0], (unknown * prior.elevation_std_rad) ** 2)
    Z = ca.evalf(about_z(ca.SX(prior.spin_rad))).full()
    covariance: Array = Z @ P @ Z.T
    return covariance
