"""The pen that a recording shows, where no pen file says it.

What the readings tell is measured: rates, noise and a gyroscope's bias at rest, how the pen leans
then. What they cannot tell is assumed, and said: above all which axis of the sensor is the pen's,
where its tip is, and how its hand moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from estimation.recording import Recording
from models.errors import InputError
from models.motion import Motion, TipBoundedVelocity
from models.outputs import UNIFORM_ANGLE_STD_RAD
from models.parsed import toml_data
from models.pen_file import load_pen, parse_pen
from models.version import version
from pen_mhe.no_pen.any_pen import ACCEL, CAMERA, GYRO, any_pen
from pen_mhe.no_pen.at_rest import AtRest, at_rest, has_gravity, inertial_of
from pen_mhe.no_pen.axis import AnyAxis
from pen_mhe.no_pen.camera_table import camera_table
from pen_mhe.no_pen.found_pen import FoundPen
from pen_mhe.no_pen.inertial_tables import inertial_table
from pen_mhe.no_pen.lines import ASSUMED, MEASURED, PenLine, pen_text
from pen_mhe.no_pen.mounted import MountedHow, mounted_how
from recordings.asked import ColumnsAsked
from recordings.read import RecordingPath, read_written
from recordings.written import WrittenRecording

GRAVITY_M_S2 = 9.81
NO_GRAVITY = (
    "accel is left out, for there is no gravity in it (user or linear acceleration): what it reads "
    "says nothing of tilt"
)
MOSTLY = 2.0
"""Of a sensor's own noise, beyond which the jitter of stamps is most of it."""
TILT_STD_DEG, TILT_STD_MOVING_DEG = 10.0, 30.0
"""Of elevation at the beginning, at rest and where the pen moves already."""
HAND = "reference"
"""Bundled pen whose hand turns one that turns about its tip …"""
CALM = TipBoundedVelocity(speed_m_s=0.2, correlation_time_s=0.15)
TIP_AT_REST = TipBoundedVelocity(speed_m_s=0.03, correlation_time_s=0.1)
"""… and how far from rest such a tip is: as one that writes."""


def pen_for(
    recording: Recording | WrittenRecording | RecordingPath,
    axis: AnyAxis | None = None,
    *,
    units: Mapping[str, str] | None = None,
    columns: ColumnsAsked | None = None,
    strict: bool = False,
) -> FoundPen:
    """Find a pen for a recording of which there is no pen file.

    Parameters
    ----------
    recording : with sensors ``accel``, ``gyro`` or ``camera``, or the path of one, or paths
    axis : of the sensor that points along the pen from tip to top: ``"-x"``, or three numbers;
        None takes what the motion or gravity shows
    units, columns, strict : of a file, see `recordings.read.read_written`

    Returns
    -------
    The pen, the text of its file with where each number comes from, and notes on what is not known

    Raises
    ------
    InputError
        If the recording is none, or has no such sensor.
    """
    if isinstance(recording, Recording):
        recording = WrittenRecording(recording)
    elif not isinstance(recording, WrittenRecording):
        recording = read_written(recording, any_pen(), units=units, columns=columns, strict=strict)
    read = recording.recording
    names = [name for name in any_pen().sensors if name in read.readings]
    if not names:
        raise InputError(
            f"recording {read.name} has the sensors {', '.join(read.readings)}, expected one of "
            f"{', '.join(any_pen().sensors)} to find a pen for"
        )
    notes: list[str] = []
    if ACCEL in names and not has_gravity(read):
        names.remove(ACCEL)
        read = read.select([name for name in read.readings if name != ACCEL]) if names else read
        notes.append(NO_GRAVITY)
    if not names:
        raise InputError(f"recording {read.name}: {NO_GRAVITY}, expected one with gravity")
    inertial = inertial_of(any_pen(), names)
    rest = at_rest(read, inertial)
    mounted = mounted_how(read, rest, axis)
    title = f"pen of {Path(read.name).name}"
    tables = {
        "": _top(title),
        **_motion(mounted, names),
        "prior": _prior(mounted),
    }
    noises = []
    for name, sensor in inertial.items():
        readings = read.sensor(name)
        table, noise = inertial_table(name, sensor, readings, rest=rest, placed=mounted.lines())
        tables[f"sensors.{name}"] = table
        noises.append(noise)
    notes += [*_rest_notes(read, rest, names), *mounted.notes]
    if CAMERA in names:
        camera = camera_table(read, rest, mounted)
        if camera.lines:
            tables[f"sensors.{CAMERA}"] = list(camera.lines)
        if any(camera.level_rad):
            level = [round(float(np.degrees(each)), 3) for each in camera.level_rad]
            tables[""].append(
                PenLine("level_deg", level, MEASURED, "gravity in the camera's frame")
            )
        notes += camera.notes
        if camera.prior:
            tables["prior"] = list(camera.prior)
    # By a noise that is mostly jitter a hand would rest.
    if GYRO in names and all(noise.std < MOSTLY * noise.own_std for noise in noises):
        why = "while nothing moves, the rate is zero"
        tables["sensors.rest"] = [PenLine("kind", "rest", ASSUMED, why)]
    text = pen_text(_head(read.name), tables)
    pen = parse_pen(toml_data(text, title), title)
    notes.append(_not_known(mounted, f"sensors.{CAMERA}" in tables))
    return FoundPen(pen, text, tuple(notes), mounted.findings)


def _top(title: str) -> list[PenLine]:
    return [
        PenLine("name", title),
        PenLine("degrees_of_freedom", 6, ASSUMED, "it turns freely"),
        PenLine("gravity_m_s2", GRAVITY_M_S2, ASSUMED),
    ]


def _motion(mounted: MountedHow, names: list[str]) -> dict[str, list[PenLine]]:
    """Return the tables of a stated hand: one whose tip rests, or one that moves at will."""
    turns = mounted.arm_m is not None
    motion, why = Motion(), "a stated hand, that moves at will"
    if names == [ACCEL]:
        motion = Motion(tip=CALM)
        why = "a stated hand, a calm one: without a gyroscope no other shows tilt"
    elif turns:
        motion = Motion(tip=TIP_AT_REST, attitude=load_pen(HAND).motion.attitude)
        why = "a stated hand, that turns the pen about its tip"
    return {
        f"motion.{part}": [
            PenLine(key, list(value) if isinstance(value, tuple) else value, ASSUMED, why)
            if key != "chain"
            else PenLine(key, value)
            for key, value in getattr(motion, part)
        ]
        for part in type(motion).model_fields
    }


def _prior(mounted: MountedHow) -> list[PenLine]:
    angles = mounted.angles_rad()
    if angles is None:
        return [PenLine("elevation_std_deg", 45.0, ASSUMED, "nothing shows it")]
    elevation, spin = (float(np.degrees(angle)) for angle in angles)
    std = TILT_STD_DEG if mounted.starts_still else TILT_STD_MOVING_DEG
    unknown = float(np.degrees(UNIFORM_ANGLE_STD_RAD))
    about = min(unknown, std / max(np.cos(np.radians(elevation)), std / unknown))
    how = "by gravity at the beginning"
    return [
        PenLine("elevation_deg", round(elevation, 2), MEASURED, how),
        PenLine("elevation_std_deg", std, ASSUMED),
        PenLine("spin_deg", round(spin, 2), MEASURED, how),
        PenLine("spin_std_deg", round(about, 2), ASSUMED),
    ]


def _rest_notes(recording: Recording, rest: AtRest | None, names: list[str]) -> list[str]:
    if not {ACCEL, GYRO} & set(names):
        return []
    if rest is None:
        return [
            "rest: the recording is never still for 1.2 s, so noise and bias are assumed, with a "
            "wide prior; a few seconds at rest in the beginning would tell them"
        ]
    shows = "noise and the gyroscope's bias are" if GYRO in names else "noise is"
    first = rest.stills[0].start_s - float(recording.time_s[0])
    said = [f"rest: {shows} measured in {rest.duration_s:.2g} s, from {first:.2g} s on"]
    if ACCEL in names:
        norm = float(np.linalg.norm(rest.mean(ACCEL)))
        off = norm - GRAVITY_M_S2
        side = "above" if off > 0 else "below"
        said.append(
            f"gravity: at rest |f| is {norm:.4g} m/s², {abs(off):.2g} {side} gravity; a bias "
            "across gravity does not show, and tilts the estimate by "
            f"{np.degrees(0.1 / GRAVITY_M_S2):.2g}° for each 0.1 m/s²"
        )
    return said


def _not_known(mounted: MountedHow, has_camera: bool) -> str:
    tip = (
        "the tip is where the motion turns"
        if mounted.arm_m is not None
        else "the tip is the sensor"
    )
    if has_camera:
        return f"not known without a pen file: {tip}, not the pen's, and the target sits there too"
    return (
        f"not known without a pen file and a camera: where the pen is and which way it points on "
        f"the table ({tip}; azimuth counts from any direction): the table says not_observable"
    )


def _head(name: str) -> list[str]:
    return [
        f"The pen that {Path(name).name} shows, found by pen-mhe {version()} without a pen file.",
        "Behind each number stands where it comes from: measured in the recording, told on the",
        "command line, or assumed because nothing shows it. Change what you know better, and",
        "estimate again with --pen and this file.",
    ]
