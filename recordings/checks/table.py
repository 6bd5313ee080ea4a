"""The table of checks: what each asks of a recording, in the order in which they ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from recordings.checks.camera import check_camera
from recordings.checks.clipping import check_clipping
from recordings.checks.gaps import check_gaps
from recordings.checks.handedness import check_handedness
from recordings.checks.jitter import check_jitter
from recordings.checks.lag import check_lag
from recordings.checks.looked import Looked
from recordings.checks.missing_gravity import check_missing_gravity
from recordings.checks.mounting import check_mounting
from recordings.checks.noise import check_noise
from recordings.checks.rates import check_rates
from recordings.checks.scale import check_scale
from recordings.checks.stuck import check_stuck
from recordings.checks.time_unit import check_unit_of_times
from recordings.checks.units import check_unit_of_readings
from recordings.finding import Finding


@dataclass(frozen=True)
class Check:
    """A question that is asked of every recording.

    Parameters
    ----------
    name : of the check
    asks : the question, in words
    find : what answers it
    unless : checks that make it meaningless where they found that no answer can be meant
    of_pen : whether it compares with what a pen file says of mounting and noise
    """

    name: str
    asks: str
    find: Callable[[Looked], Iterator[Finding]]
    unless: tuple[str, ...] = ()
    of_pen: bool = False


CHECKS = (
    Check("time unit", "Are times seconds?", check_unit_of_times),
    Check("rates", "Do sensors read as often as a hand moves?", check_rates, ("time unit",)),
    Check("gaps", "Are stretches of readings missing?", check_gaps, ("time unit",)),
    Check("jitter", "Are stamps those of sampling?", check_jitter, ("time unit",)),
    Check("stuck", "Does a sensor repeat one reading?", check_stuck, ("time unit",)),
    Check(
        "missing gravity",
        "Is gravity in the accelerometer?",
        check_missing_gravity,
        ("time unit",),
    ),
    Check(
        "units",
        "Do readings make sense in their units?",
        check_unit_of_readings,
        ("time unit", "missing gravity"),
    ),
    Check("clipping", "Does a sensor reach the end of its range?", check_clipping, ("units",)),
    Check(
        "scale",
        "Is gravity as long as it is, and do rates turn it as fast?",
        check_scale,
        ("time unit", "missing gravity", "units", "clipping"),
    ),
    Check(
        "handedness",
        "Does gravity turn in the accelerometer as the gyroscope says?",
        check_handedness,
        ("time unit", "missing gravity", "units"),
    ),
    Check(
        "mounting",
        "Is the pen above the table, and its chip where the pen file has it?",
        check_mounting,
        ("time unit", "missing gravity", "units", "clipping"),
        of_pen=True,
    ),
    Check(
        "noise",
        "Is a resting sensor as noisy as the pen file says?",
        check_noise,
        ("time unit", "units"),
        of_pen=True,
    ),
    Check(
        "lag",
        "Are accelerometer and gyroscope of one clock?",
        check_lag,
        ("time unit", "missing gravity", "units"),
    ),
    Check(
        "camera",
        "Does the camera see the pen stand and turn as its inertial sensors feel it?",
        check_camera,
        ("time unit", "missing gravity", "units", "clipping", "handedness", "mounting"),
        of_pen=True,
    ),
)
"""A check exists, for the command, the reader, estimates and the docs, with its row here."""
