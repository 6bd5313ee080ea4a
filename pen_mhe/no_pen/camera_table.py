"""The table of a camera in a pen file that is found in a recording, or why it is left out.

How its target is turned on the pen tell both by what they turn: from frame to frame by the rotation
vector δ in the target's axes, and γ in the gyroscope's, γ = Q δ. With Q gravity shows in the frame
of the camera, whose z has to be up, more or less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from models.arrays import Array
from pen_mhe.no_pen.any_pen import ACCEL, CAMERA, GYRO
from pen_mhe.no_pen.at_rest import AtRest
from pen_mhe.no_pen.inertial_tables import rate_hz
from pen_mhe.no_pen.lines import ASSUMED, MEASURED, PenLine
from pen_mhe.no_pen.mounted import MountedHow

STEEPEST_DEG = 45.0
"""Between the camera's z and up, to be used."""
LEVEL_DEG = 1.0
"""Less is not told from a bias of the accelerometer."""
LEAST_TURN = 0.05
"""Second singular value of γ δᵀ, rad² in all: turns about one axis only do not tell Q."""
USUAL_M, USUAL_RAD = 2e-3, np.radians(1.0)
LEAST_M, LEAST_RAD = 5e-4, np.radians(0.2)
PRIOR_STD_M, PRIOR_STD_DEG = 0.1, 20.0
STEP_S = 0.1
"""Between frames whose turns are compared, at least."""


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """A camera's table; without lines it is left out.

    Parameters
    ----------
    level_rad : of the pen file
    prior : its lines on place and attitude, by the first pose
    """

    lines: tuple[PenLine, ...]
    notes: tuple[str, ...]
    level_rad: tuple[float, float] = (0.0, 0.0)
    prior: tuple[PenLine, ...] = ()


def camera_table(recording: Recording, rest: AtRest | None, mounted: MountedHow) -> FoundCamera:
    """Return the table of a recording's camera."""
    times, poses = recording.sensor(CAMERA)
    turned = Rotation.from_rotvec(poses[:, 3:])
    Q, why = _target_to_sensor(recording, rest, times, turned)
    up = _up_of_frame(recording, times, turned, Q)
    angle = 0.0 if up is None else float(np.degrees(np.arccos(np.clip(up[2], -1, 1))))
    if angle > STEEPEST_DEG:
        return FoundCamera(
            (),
            (
                f"camera: left out, for its frame's z is {angle:.0f}° off up; turn its poses so "
                "that z is up, or write a pen file",
            ),
        )
    level = (0.0, 0.0)
    if up is not None and angle > LEVEL_DEG:
        across = np.radians(angle) * np.array([-up[1], up[0]]) / np.hypot(up[0], up[1])
        level = (float(across[0]), float(across[1]))
    spread_m, spread_rad, origin, how = _noise(rest, times, poses)
    to_body = Rotation.from_matrix(np.array(mounted.axis.sensor_to_body())) * Q
    rows = [[float(f"{each:.9f}") for each in row] for row in to_body.as_matrix()]
    place = "the target is taken to sit where the inertial sensor does"
    lines = (
        PenLine("kind", "pose_camera"),
        PenLine("rate_hz", float(f"{rate_hz(times):.4g}"), MEASURED, "median interval"),
        PenLine("position_std_mm", float(f"{1e3 * spread_m:.3g}"), origin, how),
        PenLine("orientation_std_deg", float(f"{np.degrees(spread_rad):.3g}"), origin, how),
        PenLine("position_m", mounted.place_m(), ASSUMED, place),
        PenLine("sensor_to_body", rows, *why),
    )
    leans = f"; its z is {angle:.1f}° off up (level_deg)" if level != (0.0, 0.0) else ""
    note = (
        f"camera: {len(times)} poses; its frame is the world's{leans}, target's turn {why[0]}; "
        "taken as stamped at their capture, where the inertial sensor sits"
    )
    prior = _prior(poses[0, :3], turned[0] * to_body.inv(), np.array(mounted.place_m()))
    return FoundCamera(lines, (note,), level, prior)


def _prior(position: Array, body_to_world: Rotation, place: Array) -> tuple[PenLine, ...]:
    """Return the lines of a prior about a pose of the target."""
    axis, up = body_to_world.apply([0, 0, 1]), body_to_world.inv().apply([0, 0, 1])
    tip = position - body_to_world.apply(place)
    angles = {
        "azimuth": np.arctan2(axis[1], axis[0]),
        "elevation": np.arcsin(np.clip(axis[2], -1, 1)),
        "spin": np.arctan2(up[1], -up[0]),
    }
    how = "by the first pose"
    lines = [PenLine("tip_m", [round(float(x), 4) for x in tip], MEASURED, how)]
    for name, angle in angles.items():
        lines.append(PenLine(f"{name}_deg", round(float(np.degrees(angle)), 2), MEASURED, how))
        lines.append(PenLine(f"{name}_std_deg", PRIOR_STD_DEG, ASSUMED))
    return (*lines, PenLine("tip_std_m", PRIOR_STD_M, ASSUMED))


def _target_to_sensor(
    recording: Recording, rest: AtRest | None, times: Array, turned: Rotation
) -> tuple[Rotation, tuple[str, str]]:
    """Return the rotation from the target's axes to the inertial sensors', and how it is known."""
    unknown = (ASSUMED, "the target is taken to be turned as the inertial sensor")
    if GYRO not in recording.readings or len(times) < 3:
        return Rotation.identity(), unknown
    at, rate = recording.sensor(GYRO)
    rate = rate - (np.zeros(3) if rest is None else rest.rate_mean(GYRO))
    every = max(1, round(STEP_S / float(np.median(np.diff(times)))))
    chosen = np.arange(0, len(times), every)
    inside = chosen[(times[chosen] >= at[0]) & (times[chosen] <= at[-1])]
    if len(inside) < 3:
        return Rotation.identity(), unknown
    delta = (turned[inside[:-1]].inv() * turned[inside[1:]]).as_rotvec()
    sums = np.vstack(
        [np.zeros(3), np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(at)[:, None], axis=0)]
    )
    whole = np.column_stack([np.interp(times[inside], at, column) for column in sums.T])
    gamma = np.diff(whole, axis=0)
    near = np.diff(times[inside]) < 3 * STEP_S * every  # not across a gap
    U, S, Vt = np.linalg.svd(gamma[near].T @ delta[near])
    if S[1] < LEAST_TURN:
        return Rotation.identity(), unknown
    D = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    return Rotation.from_matrix(U @ D @ Vt), (MEASURED, "by what gyroscope and camera turn")


def _up_of_frame(recording: Recording, times: Array, turned: Rotation, Q: Rotation) -> Array | None:
    """Return up (3,) in the camera's frame, a unit vector; None where nothing feels gravity."""
    if ACCEL not in recording.readings:
        return None
    at, force = recording.sensor(ACCEL)
    seen = np.column_stack([np.interp(times, at, column) for column in force.T])
    mean = (turned * Q.inv()).apply(seen).mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean))


def _noise(rest: AtRest | None, times: Array, poses: Array) -> tuple[float, float, str, str]:
    """Return deviations of a frame's position, m, and orientation, rad, and how they are known."""
    still = [] if rest is None else [
        poses[(times >= each.start_s) & (times <= each.stop_s)] for each in rest.stills
    ]  # fmt: skip
    still = [each for each in still if len(each) >= 8]
    if not still:
        return USUAL_M, USUAL_RAD, ASSUMED, "no frames at rest show it"
    spread = np.sqrt(np.mean([each.var(axis=0, ddof=1) for each in still], axis=0))
    return (
        max(float(spread[:3].max()), LEAST_M),
        max(float(spread[3:].max()), LEAST_RAD),
        MEASURED,
        "frames at rest, and at least what a camera leaves",
    )
