"""Check: is the pen above the table, and its chip where the pen file has it?

Gravity points out of the table; where a tip rests, the lever of a chip about it tells the pen's
axis as well (`recordings.checks.mountings`). Nothing tells an accelerometer whose three signs are
flipped from one mounted upside down: both are proposed.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from recordings.checks.axes_fit import CANDIDATES
from recordings.checks.handedness import columns_remedy, wrong_axes
from recordings.checks.looked import Looked
from recordings.checks.mountings import axis_of, is_told, matrix_text, mounting_of, nearest_axis
from recordings.checks.turns import WINDOW_S
from recordings.finding import Finding, Severity

ALONG = np.cos(np.radians(45.0))
"""Cosine of the angle within which a lever is where the pen file has it."""
UNDER = -np.sin(np.radians(12.0))
"""Sine of the elevation below which a pen lies under the table …"""
ALWAYS = 0.95
"""… in so many of the windows."""
APART = np.cos(np.radians(40.0))
"""Cosine of the angle beyond which two accelerometers do not feel the same gravity."""


def check_mounting(looked: Looked) -> Iterator[Finding]:
    """Find accelerometers whose gravity and lever are not those of a pen on a table."""
    found = False
    for name in looked.forces:
        lever = looked.levers.get(name)
        if lever is not None and is_told(lever):
            finding = _by_lever(looked, name, lever.axis)
        else:
            finding = _by_gravity(looked, name)
        if finding is not None:
            found = True
            yield finding
    if not found:
        yield from _against_each_other(looked)


def _by_lever(looked: Looked, name: str, axis: Array) -> Finding | None:
    place = np.array(looked.inertial[name].position_m)
    length = float(np.linalg.norm(place))
    expected = place / length if length > 0 else np.array([0.0, 0.0, 1.0])
    along = float(axis @ expected)
    if along > ALONG:
        return None
    if along < -ALONG:
        return _upside_down(looked, name, "moves on the other side of a tip that rests", 0.97)
    up = looked.ups.get(name)
    if up is not None and up @ axis < 0 and up @ axis < -ALONG / 2:
        axis = -axis  # its signs are flipped, too: then the lever is, as well
    return Finding(
        f"it is mounted otherwise than in the pen file: as it moves about a tip that rests, the "
        f"pen's axis is {_named(looked, name, axis)}, in the pen file it is "
        f"{_named(looked, name, np.array([0.0, 0.0, 1.0]))}",
        _mounted_alike(looked, name),
        0.98,
        f"in the pen file (the turn about the pen's axis is not told)"
        f"{_proposed(looked, name, axis)}",
        Severity.NOT_MEANT,
    )


def _by_gravity(looked: Looked, name: str) -> Finding | None:
    time_s, force = looked.forces[name]
    window = np.floor((time_s - time_s[0]) / WINDOW_S)
    _, first, count = np.unique(window, return_index=True, return_counts=True)
    means = np.add.reduceat(force, first, axis=0) / count[:, None]
    heights = means[:, 2] / (np.linalg.norm(means, axis=1) + np.finfo(float).tiny)
    if name not in looked.ups or np.quantile(heights, ALWAYS) > UNDER:
        return None
    return _upside_down(looked, name, "has gravity from above all the time", 0.9)


def _upside_down(looked: Looked, name: str, why: str, sure: float) -> Finding:
    up = looked.ups.get(name, np.array([0.0, 0.0, -1.0]))
    axis = np.array([0.0, 0.0, -1.0])
    evidence = axis_of(up, None)
    if evidence is not None and why.startswith("has"):
        axis = nearest_axis(up)
    angle = np.degrees(np.arcsin(np.clip(up[2], -1.0, 1.0)))
    return Finding(
        f"the pen lies under the table (its elevation is {angle:.0f}° on the mean): {name} {why}. "
        "Either the signs of all three axes are flipped, or it is mounted otherwise: readings do "
        "not tell which",
        name,
        sure,
        f"{columns_remedy(looked, name, -np.eye(3))}; or else in the pen file"
        f"{_proposed(looked, name, axis)}",
        Severity.NOT_MEANT,
    )


def _mounted_alike(looked: Looked, name: str) -> str:
    return ", ".join([name, *(pair.rate for pair in looked.pairs if pair.force == name)])


def _named(looked: Looked, name: str, axis: Array) -> str:
    """Return a direction of the body as one along the sensor's axes: ``-x of the chip``."""
    own = nearest_axis(np.array(looked.inertial[name].sensor_to_body).T @ axis)
    at = int(np.argmax(np.abs(own)))
    return f"{'-' if own[at] < 0 else ''}{'xyz'[at]} of the chip"


def _proposed(looked: Looked, name: str, axis: Array) -> str:
    """Return lines of a pen file in which an axis of the body becomes the pen's."""
    was = np.array(looked.inertial[name].sensor_to_body)
    new = mounting_of(nearest_axis(was.T @ axis), was)
    lines = [f"\n[sensors.{name}]\nsensor_to_body = {matrix_text(new)}"]
    for pair in looked.pairs:
        if pair.force == name:
            way = wrong_axes(pair.fit)
            P = CANDIDATES[way or 0]
            if np.linalg.det(P) < 0:
                P = -P
            turned = new @ was.T @ P @ np.array(looked.inertial[pair.rate].sensor_to_body)
            lines.append(f"\n[sensors.{pair.rate}]\nsensor_to_body = {matrix_text(turned)}")
    return "".join(lines)


def _against_each_other(looked: Looked) -> Iterator[Finding]:
    """Find two accelerometers that feel gravity from different sides."""
    names = list(looked.ups)
    for name in names[1:]:
        one, other = looked.ups[names[0]], looked.ups[name]
        if one @ other < APART:
            angle = np.degrees(np.arccos(np.clip(one @ other, -1.0, 1.0)))
            yield Finding(
                f"gravity in it is {angle:.0f}° from that in {names[0]}: one of them is mounted "
                "otherwise than in the pen file, or has a flipped sign",
                f"{names[0]}, {name}",
                0.95,
                "look at their sensor_to_body and at the signs of their columns",
                Severity.NOT_MEANT,
            )
