"""Streams in which some readings arrive late, and what a run in order of capture would be given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimation.recording import Measurement
from models.state_space import StateSpaceModel


@dataclass(frozen=True)
class Delays:
    """How the last sensor's readings come late.

    Parameters
    ----------
    most : samples that come first, at most
    off : part of them that was captured between two samples, the others at one
    """

    most: int = 3
    off: float = 0.5


def late_stream(
    model: StateSpaceModel,
    measurements: Sequence[Measurement],
    rng: np.random.Generator,
    delays: Delays | None = None,
) -> list[Measurement]:
    """Return the measurements in order of arrival, those of the last sensor apart and late."""
    delays, n_late = delays or Delays(), model.sensors[-1].n_y
    first = model.n_y - n_late
    arrivals: list[tuple[float, Measurement]] = []
    for k, m in enumerate(measurements):
        early, late = m.y.copy(), m.y.copy()
        early[first : model.n_y], late[:first] = np.nan, np.nan
        arrivals.append((float(k), Measurement(m.time_s, early)))
        if not np.isfinite(late[: model.n_y]).any():
            continue
        time_s, delay = m.time_s, int(rng.integers(0, delays.most + 1))
        if k and rng.uniform() < delays.off:
            time_s -= float(rng.uniform(0.1, 0.9)) * (time_s - measurements[k - 1].time_s)
        arrivals.append((k + delay + 0.5, Measurement(time_s, late)))
    arrivals.sort(key=lambda arrival: arrival[0])
    return [measurement for _, measurement in arrivals]


def in_order(arrived: Sequence[Measurement], n_y: int) -> list[Measurement]:
    """Return what had arrived in order of capture.

    A late row joins one of its instant that has none of its readings.
    """
    rows: list[Measurement] = []
    for m in arrived:
        at = sum(row.time_s <= m.time_s for row in rows)
        late, new = at < len(rows), np.isfinite(m.y[:n_y])
        same = [k for k in range(at) if rows[k].time_s == m.time_s]
        free = [k for k in same if late and not (np.isfinite(rows[k].y[:n_y]) & new).any()]
        if free:
            joined = np.where(np.isfinite(m.y), m.y, rows[free[-1]].y)
            rows[free[-1]] = Measurement(m.time_s, joined)
        else:
            rows.insert(at, m)
    return rows


def is_late(stream: Sequence[Measurement], k: int) -> bool:
    """Whether a measurement is older than one before it."""
    return k > 0 and stream[k].time_s < max(m.time_s for m in stream[:k])
