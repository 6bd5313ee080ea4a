"""Successive parts of a recording as one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from estimation.recording import Recording
from estimation.truth import Truth


def joined(parts: Sequence[Recording]) -> Recording:
    """Return successive parts, at least one, of the same sensors and without inputs, as one.

    The truth is left out.
    """
    first = parts[0]
    return dataclasses.replace(
        first,
        time_s=np.concatenate([part.time_s for part in parts]),
        readings={
            name: np.concatenate([part.readings[name] for part in parts]) for name in first.readings
        },
        truth=None,
        arrivals={
            name: np.concatenate([part.arrivals[name] for part in parts]) for name in first.arrivals
        },
    )


def joined_truth(parts: Sequence[Truth]) -> Truth | None:
    """Return the truth of successive parts as one; None of no part."""
    if not parts:
        return None
    return Truth(
        np.concatenate([part.time_s for part in parts]),
        parts[0].names,
        np.concatenate([part.values for part in parts]),
    )
