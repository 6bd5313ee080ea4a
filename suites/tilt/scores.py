"""What is measured of an estimated direction of gravity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from benchmark.tasks.task import Quantity, Series
from models.arrays import Array
from suites.tilt.samples import TiltSamples

FIRST_S = 1.0
"""The first moments."""


def scores(samples: TiltSamples, direction: Array) -> tuple[Quantity, ...]:
    """Return the errors of a direction (n, 3).

    ``roll``: of atan2(R_y, R_z); ``direction``: angle between estimate and truth;
    ``jitter``: increments of the roll error from sample to sample. Of jitter and roll also
    the ratio of the RMS in the first second to that of all later samples.
    """
    errors = {name: of(samples, direction) for name, of in ERRORS.items()}
    jitter = np.diff(errors["roll"])
    first = samples.time_s - samples.time_s[0] <= FIRST_S
    return (
        *(Quantity.of_errors(name, "deg", error) for name, error in errors.items()),
        Quantity.of_errors("jitter", "deg", jitter),
        Quantity.single("jitter, first by later", "1", _ratio(jitter, first[1:])),
        Quantity.single("roll, first by later", "1", _ratio(errors["roll"], first)),
    )


def roll_error_deg(samples: TiltSamples, direction: Array) -> Array:
    """Return estimate minus truth (n,) of atan2(R_y, R_z), within half a turn."""
    away = np.arctan2(direction[:, 1], direction[:, 2]) - _true_roll(samples)
    return np.degrees(np.arctan2(np.sin(away), np.cos(away)))


def direction_error_deg(samples: TiltSamples, direction: Array) -> Array:
    """Return the angle (n,) between estimated and true direction."""
    # By half the chord: exact for small angles, where the inner product is not.
    chord = np.linalg.norm(direction - samples.direction, axis=1)
    return np.degrees(2 * np.arcsin(np.minimum(chord / 2, 1.0)))


ERRORS: Mapping[str, Callable[[TiltSamples, Array], Array]] = MappingProxyType(
    {"roll": roll_error_deg, "direction": direction_error_deg}
)
"""Quantity → its errors (n,), deg, of a direction (n, 3)."""


def angle_series(samples: TiltSamples, direction: Array, std: Array | None) -> tuple[Series, ...]:
    """Return roll, unwrapped along the truth, and the direction's error, over time.

    Parameters
    ----------
    std : (n,) of the roll as claimed, deg; None where there is none
    """
    true = np.degrees(np.unwrap(_true_roll(samples)))
    estimate = true + roll_error_deg(samples, direction)
    error = direction_error_deg(samples, direction)
    return (
        Series("roll", "deg", samples.time_s, estimate, std, true),
        Series("direction error", "deg", samples.time_s, error),
    )


def _true_roll(samples: TiltSamples) -> Array:
    return np.asarray(np.arctan2(samples.direction[:, 1], samples.direction[:, 2]))


def _ratio(errors: Array, first: NDArray[np.bool_]) -> float:
    early, late = (np.sqrt(np.mean(part**2)) for part in (errors[first], errors[~first]))
    return float(early / late)
