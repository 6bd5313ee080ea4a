"""How a sensor sits on a pen that no file describes: told, seen in its motion, or by gravity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from pen_mhe.no_pen.any_pen import ACCEL, GYRO
from pen_mhe.no_pen.at_rest import AtRest, first_rows
from pen_mhe.no_pen.axis import AnyAxis, PenAxis, axis_along, next_upright, read_axis
from pen_mhe.no_pen.lines import ASSUMED, MEASURED, TOLD, PenLine
from recordings.checks.axes_fit import fit_axes
from recordings.checks.lever import Lever, lever_of
from recordings.checks.mountings import axis_of, is_told, up_of
from recordings.checks.turns import gravity_turns
from recordings.finding import Finding

START_S = 0.5
"""What the pen's attitude at the beginning is read from, where it does not rest then."""
ALIKE = 0.3
"""How much nearer to up than the next an axis is at least, as a part of gravity, to be sure."""


@dataclass(frozen=True, eq=False)
class MountedHow:
    """How the sensors sit.

    Parameters
    ----------
    axis : the pen's, in the sensors' axes
    origin, why : of it, as in the pen file
    up : (3,) unit vector at the beginning, in the sensors' axes; None where none is seen
    starts_still : whether that is of a rest
    arm_m : (3,) from the tip, in the pen's axes; None where the motion does not tell
    notes : sentences
    findings : what an estimate suffers from if it is otherwise
    """

    axis: PenAxis
    origin: str
    why: str
    up: Array | None
    starts_still: bool
    arm_m: Array | None
    notes: tuple[str, ...]
    findings: tuple[Finding, ...] = ()

    def lines(self) -> list[PenLine]:
        """Return what a sensor's table says of its mounting."""
        origin, why = ASSUMED, "tip and sensor are taken as one place"
        if self.arm_m is not None:
            origin, why = MEASURED, "from the point about which the motion turns"
        return [
            PenLine("position_m", self.place_m(), origin, why),
            PenLine("sensor_to_body", self.axis.sensor_to_body(), self.origin, self.why),
        ]

    def place_m(self) -> list[float]:
        """Return where the sensors sit, from the tip in the pen's axes."""
        return [0.0] * 3 if self.arm_m is None else [round(float(d), 4) + 0.0 for d in self.arm_m]

    def angles_rad(self) -> tuple[float, float] | None:
        """Return elevation and spin at the beginning; None where up is not seen."""
        if self.up is None:
            return None
        up = np.array(self.axis.sensor_to_body()) @ self.up
        return self.axis.elevation_rad(self.up), float(np.arctan2(up[1], -up[0]))


def mounted_how(recording: Recording, rest: AtRest | None, axis: AnyAxis | None) -> MountedHow:
    """Return how the sensors of a recording sit.

    Parameters
    ----------
    rest : what it shows at rest; None where it is never still
    axis : the pen's, as somebody says it
    """
    told = None if axis is None else read_axis(axis)
    seen = {name: recording.sensor(name) for name in (ACCEL, GYRO) if name in recording.readings}
    if ACCEL not in seen:
        chosen = told or axis_along(np.array([0.0, 0.0, 1.0]))
        why = "no accelerometer shows gravity" if told is None else "--axis"
        note = f"axis: {chosen.name} is taken to point along the pen, from tip to top ({why})"
        return MountedHow(
            chosen, ASSUMED if told is None else TOLD, why, None, False, None, (note,)
        )
    force = seen[ACCEL][1]
    usual = up_of(force) if rest is None else _unit(rest.mean(ACCEL))
    lever = _lever(recording, seen, rest)
    found = axis_of(usual, lever)
    up, starts_still = _up_at_start(recording, rest)
    if told is not None:
        chosen, origin, why = told, TOLD, "--axis"
    elif found is None:
        chosen, origin = axis_along(np.array([0.0, 0.0, 1.0])), ASSUMED
        why = "no gravity shows in the accelerometer"
    else:
        chosen = axis_along(found.axis)
        origin = MEASURED if found.by_lever else ASSUMED
        why = "the motion turns about a point along it" if found.by_lever else _upright(rest)
    arm = None
    if lever is not None and is_told(lever):
        arm = np.array(chosen.sensor_to_body()) @ lever.arm_m
        # A tip that is told to be elsewhere: the point about which it turns is not the pen's.
        arm = arm if arm[2] > 0.5 * lever.length_m else None
    findings: tuple[Finding, ...] = ()
    notes = [f"axis: {chosen.name} points along the pen, from tip to top ({origin}: {why})"]
    if usual is not None and told is None and origin == ASSUMED:
        note, findings = _by_gravity(chosen, usual, why)
        notes = [note]
    if arm is not None and lever is not None:
        notes.append(
            f"place: the motion turns about a point {100 * lever.length_m:.1f} cm from the "
            f"sensor (± {100 * float(lever.std_m.max()):.1f} cm), which is taken as the tip at rest"
        )
    return MountedHow(chosen, origin, why, up, starts_still, arm, tuple(notes), findings)


def _by_gravity(chosen: PenAxis, up: Array, why: str) -> tuple[str, tuple[Finding, ...]]:
    """Return what is said of an axis that only gravity tells, and that it may be another."""
    other = next_upright(up, chosen)
    here, there = (float(np.degrees(each.elevation_rad(up))) for each in (chosen, other))
    sure = np.sin(np.radians(here)) - np.sin(np.radians(there)) >= ALIKE
    guess = Finding(
        f"that {chosen.name} is the pen's axis is a guess, and deviations are those of this axis",
        ACCEL,
        1.0,
        f"say --axis; {other.name} is about as upright",
        check="guessed axis",
    )
    note = (
        f"axis: {chosen.name} is {'taken' if sure else 'guessed'} to point along the pen, from tip "
        f"to top ({why}), which stands at {here:.3g}° then; with --axis {other.name} it would be "
        f"{there:.3g}°"
    )
    return note, () if sure else (guess,)


def _upright(rest: AtRest | None) -> str:
    return f"nearest to up {'on the whole' if rest is None else 'at rest'}"


def _lever(
    recording: Recording, seen: Mapping[str, tuple[Array, Array]], rest: AtRest | None
) -> Lever | None:
    """Return where the accelerometer sits; None where no gyroscope and gravity tell.

    Without rest a gyroscope's bias is what gravity does not turn by.
    """
    if GYRO not in seen:
        return None
    some = first_rows(recording)
    (force_s, force), (rate_s, rate) = some.sensor(ACCEL), some.sensor(GYRO)
    if rest is not None:
        return lever_of(force_s, force, rate_s, rate - rest.rate_mean(GYRO))
    turns = gravity_turns(force_s, force, rate_s, rate)
    if not len(turns):
        return None
    return lever_of(force_s, force, rate_s, rate + fit_axes(turns).bias[0])  # of equal axes


def _up_at_start(recording: Recording, rest: AtRest | None) -> tuple[Array | None, bool]:
    """Return up (3,) at the beginning, in the sensors' axes, and whether the pen rests then."""
    start = float(recording.time_s[0])
    if rest is not None and rest.stills[0].start_s - start < START_S:
        return _unit(rest.mean(ACCEL)), True
    times, force = recording.sensor(ACCEL)
    return up_of(force[times <= times[0] + START_S]), False


def _unit(force: Array) -> Array | None:
    return up_of(force[None, :])
