"""Which faults nobody could notice in time, computed along fault-free runs.

A change δy of the readings is explained by a change of first state, biases and process noise and
by a change of the readings' noise. What the cheapest explanation costs, as χ², is

    λ_k = min ‖δx_0‖²_P̄ + Σ ‖w_i‖² + Σ ‖δy_i - H_i δx_i‖²_R  =  Σ_{i ≤ k} δν_iᵀ S_i⁻¹ δν_i

with δν the change of the Kalman filter's innovations. It is the squared deflection of the best
test there is, one that knows the fault's form and begin and only asks whether it is there: √λ
deviations. That test, made at every instant, alarms once an hour by chance if its threshold is
`LIMIT` or lower. A fault is unnoticeable in time where the linearised estimate is wrong for
`suites.faults.scoring.SILENT_S` before λ reaches that. Linearised is the EKF about the fault-free
run: by differences of runs with a small part of δy.

    python -m suites.faults.unnoticeable > suites/faults/unnoticeable.toml
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from scipy.stats import norm

from estimation.estimator import BatchEstimator, Estimator, StateT
from models.arrays import Array
from models.parsed import toml_data
from models.state_space import StateSpaceModel
from suites.faults.cells import Bench, bench_of
from suites.faults.given_rows import GivenRows
from suites.faults.inject import injected
from suites.faults.protocol import SENSORS, faults_for
from suites.faults.scoring import SILENT_S, WRONG_STDS
from suites.faults.table import INSTANT_S, Fault

FILE = Path(__file__).with_name("unnoticeable.toml")
SEEDS = 10
"""Of the full table."""
ESTIMATOR = "ekf"
TESTS_HZ = 100.0
LIMIT = float(norm.isf(1 / (3600 * TESTS_HZ))) ** 2
"""λ from which a test at 100 Hz with one false alarm an hour finds a fault as often as not."""
PART = 1e-3
"""Of δy, in which estimates are linear."""


@dataclass(frozen=True, eq=False)
class Response:
    """What the linearised estimator makes of a change of its readings.

    Parameters
    ----------
    time_s : (n,)
    cost : (n,) λ up to each instant
    shift : (n, n_o) of the outputs, in claimed deviations
    """

    time_s: Array
    cost: Array
    shift: Array


class InBatches(Estimator[StateT], BatchEstimator[StateT], Protocol[StateT]):
    """An estimator that takes many measurements at once."""


def response(estimator: InBatches[Any], time_s: Array, y: Array, changed: Array) -> Response:
    """Return what a change of readings does, linearised about the run without it.

    Parameters
    ----------
    time_s : (n,)
    y, changed : (n, n_row) without and with the change; a reading that either lacks does not change
    """
    change = np.nan_to_num(changed - y)
    start = estimator.init()
    ahead, behind = (
        estimator.batch(start, time_s, y + sign * PART * change, covariances=True)[1]
        for sign in (1, -1)
    )
    innovation = np.nan_to_num(ahead.innovation - behind.innovation) / (2 * PART)
    cost = normalised_squared(innovation, ahead.innovation_covariance)
    shift = (ahead.values - behind.values) / (2 * PART) / ahead.values_std
    return Response(time_s, np.cumsum(cost), shift)


def normalised_squared(innovation: Array, S: Array) -> Array:
    """Return δνᵀ S⁻¹ δν (n,) of innovations (n, n_r), of the rows that were read."""
    unread = np.isnan(np.diagonal(S, axis1=1, axis2=2))
    either = unread[:, :, None] | unread[:, None, :]
    whole = np.where(either, np.eye(S.shape[1]), S)
    part = np.where(unread, 0.0, innovation)
    return np.einsum("ni,ni->n", part, np.linalg.solve(whole, part[:, :, None])[:, :, 0])


def unnoticed_s(given: Response, judged: Sequence[int]) -> tuple[float, float]:
    """Return for how long an estimate is wrong before anybody could notice, and λ by then."""
    wrong = (np.abs(given.shift[:, list(judged)]) > WRONG_STDS).any(axis=1)
    lasting_s = np.append(np.diff(given.time_s), 0.0)
    unnoticed = wrong & (given.cost < LIMIT)
    last = np.flatnonzero(unnoticed)
    return float(lasting_s[unnoticed].sum()), float(given.cost[last[-1]]) if len(last) else 0.0


def is_of_readings(fault: Fault, clean: GivenRows, hit: GivenRows) -> bool:
    """Whether a fault changes readings under their stamps, and no stamps."""
    return np.array_equal(clean.time_s, hit.time_s)


@dataclass(frozen=True)
class Unnoticeable:
    """A cell that nobody could be right about in time.

    Parameters
    ----------
    wrong_s : how long estimates are wrong before anybody could notice, in the worst seed
    cost : λ by then
    """

    fault: str
    sensors: str
    seed: int
    wrong_s: float
    cost: float


def unnoticeable(fault: Fault, sensors: str, seed: int) -> Unnoticeable | None:
    """Return why a run's fault is unnoticeable; None where it is not, or changes stamps."""
    bench: Bench = bench_of(ESTIMATOR, sensors)
    model: StateSpaceModel = bench.model
    clean = bench.stream(seed, fault.duration_s)
    hit = injected(fault, clean, model, seed)
    if not is_of_readings(fault, clean, hit):
        return None
    (time_s, y), (_, changed) = clean.stacked(model), hit.stacked(model)
    estimator = bench.estimator
    assert isinstance(estimator, BatchEstimator)
    found = response(estimator, time_s, y, changed)
    names = bench.clean(seed, fault.duration_s).names
    outputs = estimator.batch(estimator.init(), time_s[:1], y[:1])[1].names
    wrong_s, cost = unnoticed_s(found, [outputs.index(name) for name in names])
    if wrong_s <= SILENT_S + INSTANT_S:
        return None
    return Unnoticeable(fault.key, sensors, seed, wrong_s, cost)


def declared() -> tuple[Unnoticeable, ...]:
    """Return the runs that were declared unnoticeable before the suite first judged."""
    data = toml_data(FILE.read_text("utf-8"), str(FILE))
    return tuple(Unnoticeable(**row) for row in data.get("unnoticeable", ()))


def main(seeds: int = SEEDS) -> None:
    """Print the file."""
    print(
        "# Made by `python -m suites.faults.unnoticeable`, see there: the runs in which estimates"
    )
    print("# are wrong for longer than may be silent before anybody could notice it.")
    print(f"limit = {LIMIT:.4g}\nseeds = {seeds}")
    for sensors in SENSORS:
        for fault in faults_for(sensors):
            for seed in range(seeds):
                if (found := unnoticeable(fault, sensors, seed)) is not None:
                    print(
                        f"\n[[unnoticeable]]\nfault = {json.dumps(fault.key, ensure_ascii=False)}"
                    )
                    print(f'sensors = "{sensors}"\nseed = {seed}')
                    print(f"wrong_s = {found.wrong_s:.2f}\ncost = {found.cost:.3g}", flush=True)


if __name__ == "__main__":
    main()
