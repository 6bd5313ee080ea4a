"""What is usual of a watch's statistics on clean data, written to a pen file.

    python -m suites.faults.calibrate models/pens/reference.toml --hours 5
    python -m suites.faults.calibrate models/pens/dpoint.toml --recording RECORDING

Without a recording: fault-free handwriting of the pen, and of the pen told the hand that moves
it, at 0.3 and 1 times its speed, every choice of sensors, on the EKF. Of each sensor and statistic
the usual is what the largest of a part of `PART_S` exceeds in one of `PARTS` parts: no odd part
decides anything. With one: the largest in its first half, of every choice of sensors that it has,
and at least `LEAST`: half a minute does not hold what five hours do.
See `estimation.watch.limits` for what follows. Whoever judges takes other seeds, or the other half.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from benchmark.configurations import CONFIGURATIONS
from ekf_baseline import Ekf
from estimation.estimator import run
from estimation.history import EstimateHistory
from estimation.output_file import write_whole
from estimation.recording import Recording
from estimation.watch.limits import USUAL, limits_of
from models.arrays import Array
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.pen_text import PenText
from recordings.read import read_written
from recordings.simulate_pen import simulate
from suites.faults.protocol import MOTION, SENSORS, written_by_hand

SPEEDS = (0.3, 1.0)
"""At which nothing at all should be said."""
PART_S, SETTLED_S = 300.0, 1.0
PARTS = 20
KEY = "usual_innovations"
LEAST = (7.5, 5.0, 0.31, 0.19, 0.0)
"""What is usual of a recording at least: means that white samples have now and then, a third and a
fifth of their energy."""
FIRST_SEED = 5000
"""Of no other use."""


def measures(history: EstimateHistory, model: StateSpaceModel) -> Iterator[tuple[str, Array]]:
    """Yield name and `USUAL` (n, 5) of each sensor that is watched, at each of its samples.

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
            means.append((mean**2).sum(axis=1) * (2 - a) / a)
            energies.append(lfilter([a], [1.0, -b], energy))
        settled = history.time_s[there] >= SETTLED_S
        yield sensor.name, np.column_stack([*means, *energies, energy])[settled]


def of_simulated(pen: PenConfig, hours: float) -> dict[str, Array]:
    """Return sensor → the usual of each measure, (5,), of `hours` of simulated handwriting."""
    found = dict[str, Array]()
    streams = [
        (each, choice, speed)
        for each in (written_by_hand(pen), pen)
        for choice in SENSORS
        for speed in SPEEDS
    ]
    parts = max(1, round(3600 * hours / PART_S / len(streams)))
    for each, choice, speed in streams:
        of_sensor = dict[str, list[Array]]()
        for name, values in _stream(each, choice, speed, parts):
            of_sensor.setdefault(name, []).append(values.max(axis=0))
        for name, largest in of_sensor.items():
            usual = np.quantile(largest, 1 - 1 / PARTS, axis=0)
            found[name] = np.maximum(found.get(name, usual), usual)
    return found


def of_recording(pen: PenConfig, recording: Recording) -> dict[str, Array]:
    """Return sensor → the largest of each measure, (5,), in the first half of a recording."""
    half = recording.first((recording.time_s[-1] - recording.time_s[0]) / 2)
    found = dict[str, Array]()
    for choice in SENSORS:
        sensors = CONFIGURATIONS[choice].sensors
        if not set(sensors) <= set(half.readings):
            continue
        model = pen_model(pen, sensors)
        history = run(Ekf(model), half.select(sensors), covariances=True)
        for name, values in measures(history, model):
            largest = np.maximum(values.max(axis=0), LEAST)
            found[name] = np.maximum(found.get(name, largest), largest)
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


def written(path: Path, found: Mapping[str, Array], made: str) -> str:
    """Return a pen file's text with what is usual of the sensors that were found."""
    pen, text = load_pen(path), PenText.of(path)
    assert text is not None
    usual = {
        name: tuple(float(f"{value:.3g}") for value in found[name])
        for name in pen.sensors
        if name in found
    }
    sensors = {
        name: sensor.model_copy(update={KEY: usual[name]}) if name in usual else sensor
        for name, sensor in pen.sensors.items()
    }
    values = {Parameter("usual", ("sensors", name), KEY): usual[name] for name in usual}
    note = [f"What is usual of innovations ({', '.join(USUAL)}) was found by", f"  {made}"]
    return text.replaced(values, pen.model_copy(update={"sensors": sensors}), note)


def main() -> None:
    """Write the pen file anew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pen", type=Path)
    parser.add_argument("--hours", type=float, default=5.0)
    parser.add_argument("--recording", type=Path)
    given = parser.parse_args()
    pen = load_pen(given.pen)
    made = f"python -m suites.faults.calibrate {given.pen} "
    if given.recording:
        found = of_recording(pen, read_written(given.recording, pen).recording)
        made += f"--recording {given.recording.name}"
    else:
        found, made = of_simulated(pen, given.hours), f"{made}--hours {given.hours:g}"
    write_whole(given.pen, written(given.pen, found, made))


if __name__ == "__main__":
    main()
