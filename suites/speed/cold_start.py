"""How long it takes from nothing to a first estimate, each time in a fresh process.

Three figures: importing a room; the first estimate of the reference pen in a Python that has
imported everything, compiled functions in the cache; building an estimator of the pen of
[Pen] (15 states, 5 rows) where nothing is in the cache, compilation included. Shown by
``python -m suites.speed.cold_start``.
"""

from __future__ import annotations

import importlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass

RUNS = 5
IMPORTS = (
    "mhe",
    "mhe.realtime",
    "mhe.reference.ipopt",
    "ekf_baseline.ekf",
    "pen_mhe.estimators",
    "commands.cli",
)


@dataclass(frozen=True)
class ColdStart:
    """One figure: what was timed, and how long it took in each of the processes."""

    what: str
    seconds: tuple[float, ...]

    @property
    def median_s(self) -> float:
        """Median over the processes."""
        return statistics.median(self.seconds)


def import_s(module: str) -> float:
    """Return the time to import a module, s; only the first call in a process says much."""
    start = time.perf_counter()
    importlib.import_module(module)
    return time.perf_counter() - start


def first_estimate_s(estimator: str) -> float:
    """Return the time from the name of the reference pen to a first estimate, s.

    Reads the pen file, builds model and estimator, takes one step. Imports do not count.
    """
    from estimation.recording import Measurement
    from models.pen import pen_model
    from models.pen_file import load_pen
    from pen_mhe.estimators import create_estimator

    start = time.perf_counter()
    model = pen_model(load_pen("reference"), ("accel", "gyro"))
    built = create_estimator(estimator, model)
    built.step(built.init(), Measurement(0.0, model.stack({})))
    return time.perf_counter() - start


def build_s(estimator: str) -> float:
    """Return the time to build an estimator of the pen with 15 states, s; imports do not count."""
    from benchmark.bodies import BODIES
    from pen_mhe.estimators import create_estimator

    model = BODIES["pen15"]().model()
    start = time.perf_counter()
    create_estimator(estimator, model)
    return time.perf_counter() - start


def cold_start(runs: int = RUNS, estimators: Sequence[str] | None = None) -> tuple[ColdStart, ...]:
    """Time everything, every time in a process of its own with single-threaded BLAS.

    Parameters
    ----------
    runs : processes per figure
    estimators : names in `pen_mhe.estimators.ESTIMATORS`; all by default
    """
    from pen_mhe.estimators import ESTIMATORS  # not above: fresh processes import this module

    estimators = tuple(ESTIMATORS) if estimators is None else estimators
    figures = []
    for module in IMPORTS:
        seconds = tuple(_fresh(f"import_s({module!r})") for _ in range(runs))
        figures.append(ColdStart(f"import {module}", seconds))
    for estimator in estimators:
        with tempfile.TemporaryDirectory() as cache:
            call = f"first_estimate_s({estimator!r})"
            _fresh(call, cache)  # fills the cache
            seconds = tuple(_fresh(call, cache) for _ in range(runs))
        figures.append(ColdStart(f"first estimate of {estimator}, compiled before", seconds))
    for estimator in estimators:
        seconds = tuple(_fresh_with_empty_cache(f"build_s({estimator!r})") for _ in range(runs))
        figures.append(ColdStart(f"building {estimator} with 15 states, compilation", seconds))
    return tuple(figures)


def _fresh_with_empty_cache(call: str) -> float:
    with tempfile.TemporaryDirectory() as cache:
        return _fresh(call, cache)


def _fresh(call: str, cache: str | None = None) -> float:
    """Return what a function of this module says in a process of its own."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }
    if cache is not None:
        environment["PEN_MHE_CACHE"] = cache
    script = f"from suites.speed import cold_start; print(cold_start.{call})"
    command = [sys.executable, "-c", script]
    result = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return float(result.stdout)


if __name__ == "__main__":
    for figure in cold_start():
        print(f"{figure.median_s:7.3f} s  {figure.what}")
