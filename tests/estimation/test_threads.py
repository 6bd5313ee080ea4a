"""Estimators in threads of their own do not disturb each other: compiled calls run at once.

Threads that share one take turns in it: with its workspace for both the process would end.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from ekf_baseline.ukf import Ukf
from estimation.estimator import run_measurements
from estimation.recording import Measurement
from estimation.watch.watched import Watched
from mhe.config import MheConfig, MheIpoptConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from mhe.reference.ipopt import MheIpopt
from models.arrays import Array
from models.state_space import StateSpaceModel
from tests.estimation import pens

ESTIMATORS: dict[str, Callable[[StateSpaceModel], Any]] = {
    "ekf": Ekf,
    "mhe-rti": lambda model: MheRti(model, MheRtiConfig(horizon=8)),
    "mhe": lambda model: Mhe(model, MheConfig(horizon=8, huber={"accel": 2.0})),
}
N = 150
RUNS = [pens.draw_pen_run(N, seed) for seed in (1, 2)]
MODEL = RUNS[0].model
STREAMS = [
    (np.array([m.time_s for m in run.measurements]), np.array([m.y for m in run.measurements]))
    for run in RUNS
]


def followed(estimator: Any, time_s: Array, y: Array) -> Array:
    """Means (2 n, n_x) of a batch, then of single steps."""
    _, history = estimator.batch(estimator.init(), time_s, y)
    state, means = estimator.init(), []
    for t, row in zip(time_s, y, strict=True):
        state, estimate = estimator.step(state, Measurement(float(t), row))
        means.append(estimate.state.mean)
    return np.vstack([history.mean, means])


@pytest.mark.parametrize("pair", [("ekf", "ekf"), ("mhe-rti", "mhe-rti"), ("mhe", "mhe-rti")])
def test_two_at_once_are_two_in_turn(pair: tuple[str, str]) -> None:
    estimators = [ESTIMATORS[name](MODEL) for name in pair]
    wanted = [followed(e, *s) for e, s in zip(estimators, STREAMS, strict=True)]
    ready = threading.Barrier(2)

    def follow(i: int) -> list[Array]:
        ready.wait()
        return [followed(estimators[i], *STREAMS[i]) for _ in range(4)]

    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(follow, range(2)))
    for means, expected in zip(found, wanted, strict=True):
        for repeated in means:
            np.testing.assert_array_equal(repeated, expected)
    assert not np.array_equal(wanted[0], wanted[1])


SHARED: dict[str, Callable[[StateSpaceModel], Any]] = {
    **ESTIMATORS,
    "ukf": Ukf,
    "mhe-ipopt": lambda model: MheIpopt(model, MheIpoptConfig(horizon=2)),
    "watched": lambda model: Watched(Ekf(model)),
}


@pytest.mark.parametrize("name", SHARED)
def test_threads_that_share_an_estimator_take_turns(name: str) -> None:
    estimator = SHARED[name](MODEL)
    both = [run.measurements[:10] for run in RUNS]
    ready = threading.Barrier(2)

    def follow(i: int, *, wait: bool = True) -> Array:
        if wait:
            ready.wait()
        return run_measurements(estimator, both[i]).mean

    wanted = [follow(i, wait=False) for i in range(2)]
    with ThreadPoolExecutor(2) as pool:
        found = [pool.submit(follow, i) for _ in range(3) for i in range(2)]
    for i, each in enumerate(found):
        np.testing.assert_array_equal(each.result(), wanted[i % 2])


def test_estimators_may_be_built_in_threads() -> None:
    """Building generates C and loads libraries."""
    alone = followed(ESTIMATORS["mhe-rti"](MODEL), *STREAMS[0])
    with ThreadPoolExecutor(4) as pool:
        built = list(pool.map(lambda _: ESTIMATORS["mhe-rti"](MODEL), range(4)))
    for estimator in built:
        np.testing.assert_array_equal(followed(estimator, *STREAMS[0]), alone)
