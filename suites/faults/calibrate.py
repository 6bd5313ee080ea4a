"""Limits of a watch's statistics from clean data: rewrites estimation/watch/limits.toml.

    python -m suites.faults.calibrate --hours 5

Fault-free handwriting of the writer's pen and of the reference pen at 0.3 and 1 times its speed,
every choice of sensors, on the EKF. Of each kind of sensor and statistic `usual` is what the
largest of a part of `PART_S` exceeds in one of `PARTS` parts: no odd part decides anything. And

    limit = median + max(MARGIN (usual - median), FLOOR),   of energies at least their floor

with the largest median of a choice of sensors, pen and speed. Whoever judges takes other seeds.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

import estimation.watch
from benchmark.configurations import CONFIGURATIONS
from ekf_baseline import Ekf
from estimation.estimator import run
from estimation.history import EstimateHistory
from estimation.watch.limits import MEASURES, WINDOWS_S, limits_of
from models.arrays import Array
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate
from suites.faults.protocol import MOTION, SENSORS, writers_pen

SPEEDS = (0.3, 1.0)
"""At which nothing at all should be said."""
PART_S, SETTLED_S = 300.0, 1.0
PARTS = 20
MARGIN = 1.6
MEAN_FLOOR, ENERGY_FLOORS = 12.0, (0.5, 0.3)
FIRST_SEED = 5000
"""Of no other use."""


def measures(history: EstimateHistory, model: StateSpaceModel) -> Iterator[tuple[str, Array]]:
    """Yield kind and `MEASURES` (n, 4) of each sensor that is watched, at each of its samples.

    See `estimation.watch.statistics`; all samples of a sensor have all their rows here.
    """
    row = 0
    for sensor, limits in zip(model.sensors, limits_of(model), strict=True):
        rows = slice(row, row + sensor.n_r)
        row += sensor.n_r
        if limits is None:
            continue
        v = history.innovation[:, rows]
        there = ~np.isnan(v).any(axis=1)
        L = np.linalg.cholesky(history.innovation_covariance[there, rows, rows])
        z = np.linalg.solve(L, v[there][..., None])[..., 0]
        energy = (z**2).mean(axis=1)
        means, energies = [], []
        for a in limits.weights:
            b = 1 - a
            mean = lfilter([a], [1.0, -b], z, axis=0)
            share = lfilter([a * a], [1.0, -b * b], np.ones(len(z)))
            means.append((mean**2).sum(axis=1) / share)
            energies.append(lfilter([a], [1.0, -b], energy))
        settled = history.time_s[there] >= SETTLED_S
        yield sensor.kind, np.column_stack([*means, *energies])[settled]


def calibrated(hours: float) -> dict[str, tuple[Array, Array]]:
    """Return kind → largest median and usual maximum of each measure, (4,), over `hours` in all."""
    found = dict[str, tuple[Array, Array]]()
    pens = (writers_pen(), load_pen("reference"))
    streams = [(pen, choice, speed) for pen in pens for choice in SENSORS for speed in SPEEDS]
    parts = max(1, round(3600 * hours / PART_S / len(streams)))
    for pen, choice, speed in streams:
        of_kind = dict[str, list[tuple[Array, Array]]]()
        for kind, values in _stream(pen, choice, speed, parts):
            of_kind.setdefault(kind, []).append((np.median(values, axis=0), values.max(axis=0)))
        for kind, each in of_kind.items():
            median = np.max([part[0] for part in each], axis=0)
            most = np.quantile([part[1] for part in each], 1 - 1 / PARTS, axis=0)
            before = found.get(kind, (median, most))
            found[kind] = (np.maximum(before[0], median), np.maximum(before[1], most))
    return found


def _stream(pen: PenConfig, choice: str, speed: float, parts: int) -> Iterator[tuple[str, Array]]:
    sensors = CONFIGURATIONS[choice].sensors
    model = pen_model(pen, sensors)
    estimator = Ekf(model)
    for part in range(parts):
        recording = simulate(
            pen,
            sensors,
            motion=MOTION,
            duration_s=PART_S,
            seed=FIRST_SEED + part,
            speed=speed,
        )
        yield from measures(run(estimator, recording, covariances=True), model)


def table(found: dict[str, tuple[Array, Array]], hours: float) -> str:
    """Return the text of limits.toml."""
    lines = [
        "# Limits of a watch's statistics by the kind of a sensor, see the module beside:",
        f"# {', '.join(MEASURES)}.",
        "# `usual` is the largest value on most clean data; above `limit` is an alarm.",
        f"# Made of {hours:g} simulated hours by",
        f"#   python -m suites.faults.calibrate --hours {hours:g}",
    ]
    windows = len(WINDOWS_S)
    for kind, (median, most) in found.items():
        floors = np.array([MEAN_FLOOR] * windows + [0.0] * windows)
        limit = median + np.maximum(MARGIN * (most - median), floors)
        limit[windows:] = np.maximum(limit[windows:], ENERGY_FLOORS)
        lines += ["", f"[{kind}]"]
        for name, values in (("usual", most), ("limit", limit)):
            lines.append(f"{name} = [{', '.join(f'{value:.3g}' for value in values)}]")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=5.0)
    hours = parser.parse_args().hours
    path = Path(estimation.watch.__file__).with_name("limits.toml")
    path.write_text(table(calibrated(hours), hours), "utf-8")


if __name__ == "__main__":
    main()
