"""Results of a run that never was: with all that a report has to bear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmark.figures.figure import TRUTH, Figure, Line, Panel, Table
from benchmark.tasks.results import RESULT_COLUMNS, SERIES_COLUMNS, Results
from benchmark.tasks.suite import Scope, Suite
from benchmark.tasks.task import Outcome, Task, failed

NASTY = (
    "<img src=x onerror=alert(1)>",
    "</script><script>alert(2)</script>",
    "<b>bold</b> & <a href='https://example.org'>a | b</a>",
)
"""Labels as an input file could have them."""

MAIN, NO_SPIN = "free pen, handwriting", "no-spin pen, handwriting"
BELIEVED = "spin ignored"
STEP_S = {"ekf": 45e-6, "mhe-rti": 0.9e-3, "mhe": 2.1e-3}

# sensors -> tip/mm, azimuth/deg, elevation/deg, rates/(deg/s) of the EKF; None: not observable
ERRORS: dict[str, tuple[float | None, ...]] = {
    "accel": (None, None, 4.1, 60.0),
    "gyro": (None, None, None, 2.4),
    "accel+gyro": (None, None, 1.2, 2.1),
    "two accelerometers": (None, None, 1.9, 7.5),
    "accel+gyro+contact": (14.0, None, 1.1, 2.1),
    "camera": (0.61, 0.35, 0.34, 14.0),
    "two accelerometers+camera": (0.47, 0.27, 0.26, 5.5),
    "accel+gyro+camera": (0.42, 0.21, 0.2, 2.0),
}
QUANTITIES = (("tip", "mm"), ("azimuth", "deg"), ("elevation", "deg"), ("rates", "deg/s"))
PART_OF_EKF = {"ekf": 1.0, "mhe-rti": 0.97, "mhe": 0.9}

CLAIMS = """
[[claim]]
id = "pen-accurate"
source = "[Pen] 1"
says = "accelerometer only: the angles are accurate"
criterion = "RMSE of the elevation at most 1 deg"
of = { case = "free pen, handwriting", sensors = "accel", quantity = "elevation" }
at_most = 1.0
changed = [{ on = 2026-11-30, why = "it could not fail" }]

[[claim]]
id = "pen-gyro"
source = "[Pen] 2"
says = "gyroscope only: the rates are clearly better"
criterion = "RMSE of the rates, gyroscope over accelerometer: at most 0.5"
of = { case = "free pen, handwriting", sensors = "gyro", quantity = "rates" }
against = { sensors = "accel" }
every = ["estimator"]
at_most = 0.5

[[claim]]
id = "pen-open"
source = "ours"
says = "the MHE's tip error is a tenth below the EKF's"
criterion = "RMSE of the tip, MHE over EKF: at most 0.9"
of = { sensors = "accel+gyro+camera", estimator = "mhe", quantity = "tip" }
against = { estimator = "ekf" }
at_most = 0.9

[[claim]]
id = "pen-no-data"
source = "ours"
says = "this one has no runs"
criterion = "RMSE of the tip at most 1 mm"
of = { case = "never run", quantity = "tip" }
at_most = 1.0
"""

NASTY_CLAIMS = f"""
[[claim]]
id = "nasty"
source = '''{NASTY[2]}'''
says = '''{NASTY[0]}'''
criterion = '''{NASTY[1]}'''
of = {{ quantity = '''{NASTY[0]}''' }}
at_most = 1.0
"""


def results(seeds: int = 5) -> Results:
    """Return the tables of a run of both suites."""
    rows = [row for seed in range(seeds) for row in (*_pen(seed), *_nasty(seed))]
    series = [*_series("pen", MAIN, "accel+gyro"), *_series("nasty", NASTY[1], NASTY[0])]
    return Results(
        pd.DataFrame(rows, columns=list(RESULT_COLUMNS)),
        pd.DataFrame(series, columns=list(SERIES_COLUMNS)),
    )


def _pen(seed: int) -> Iterator[dict[str, Any]]:
    rng, broken = np.random.default_rng(seed), set()
    for sensors, errors in ERRORS.items():
        luck = rng.normal(1, 0.06)
        for estimator, part in PART_OF_EKF.items():
            task = Task("pen", MAIN, sensors, estimator, seed)
            if (sensors, estimator) == ("accel", "mhe-rti"):
                yield _row(task, status="failed", reason="RuntimeError: the solver | gave up\nhere")
                continue
            if (sensors, estimator) == ("camera", "mhe") and seed == 1:
                broken.add(task.key)
                yield _row(task, status="mirror", reason="settled on the mirror image")
                continue
            if (sensors, estimator) == ("two accelerometers+camera", "mhe-rti"):
                continue
            for (quantity, unit), error in zip(QUANTITIES, errors, strict=True):
                rmse = (error or 30.0) * part * luck * rng.normal(1, 0.03)
                yield _row(task, quantity, unit, rmse, error is not None)
    for estimator, part in PART_OF_EKF.items():
        for sensors, error in (("accel+gyro+camera", 1.4), ("camera", np.inf), ("gyro", np.nan)):
            task = Task("pen", MAIN, sensors, estimator, seed)
            if task.key not in broken:
                yield _row(task, "spin", "deg", error * part * rng.normal(1, 0.3))
        task = Task("pen", NO_SPIN, "accel+gyro", estimator, seed)
        yield _row(task, "elevation", "deg", 0.05 * part)
        for sensors in ("gyro", "accel+gyro"):
            task = Task("pen", BELIEVED, sensors, estimator, seed)
            yield _row(task, "elevation", "deg", 24.0 * part, sensors != "gyro", claimed=0.02)


def _nasty(seed: int) -> Iterator[dict[str, Any]]:
    for estimator in ("ekf", "mhe", NASTY[2]):
        task = Task("nasty", NASTY[1], NASTY[0], estimator, seed)
        yield _row(task, NASTY[0], NASTY[1], 1.0 + 0.01 * seed * len(estimator))
        broken = Task("nasty", NASTY[2], NASTY[1], estimator, seed)
        yield _row(broken, status="failed", reason=NASTY[0])


def _row(
    task: Task,
    quantity: str = "",
    unit: str = "",
    rmse: float = float("nan"),
    observable: bool = True,
    status: str = "ok",
    reason: str = "",
    claimed: float = float("nan"),
) -> dict[str, Any]:
    step = STEP_S.get(task.estimator, 1e-5)
    return {
        **{name: getattr(task, name) for name in ("suite", "case", "sensors", "estimator", "seed")},
        "model": "pen",
        "quantity": quantity,
        "unit": unit,
        "rmse": rmse,
        "bias": rmse / 3,
        "max_error": rmse * 3,
        "observable": observable and bool(quantity),
        "claimed": claimed,
        "samples": 500,
        "solved_fraction": 1.0 if status == "ok" else 0.4,
        "step_time_median_s": step,
        "step_time_p99_s": 1.6 * step,
        "status": status,
        "reason": reason,
    }


def _series(suite: str, case: str, sensors: str) -> Iterator[dict[str, Any]]:
    t = np.arange(0, 10, 0.01)
    truth = 60 + 12 * np.sin(1.3 * t) + 5 * np.sin(4.1 * t)
    for at, estimator in enumerate(("ekf", "mhe")):
        rng = np.random.default_rng(at)
        std = 0.4 + 6 * np.exp(-t / (0.8 - 0.4 * at))
        error = 0.35 * np.cumsum(rng.normal(size=len(t))) / np.sqrt(1 + np.arange(len(t)))
        estimate = truth + error + 20 * np.exp(-t / (0.5 - 0.25 * at))
        for k in range(len(t)):
            yield {
                "suite": suite,
                "case": case,
                "sensors": sensors,
                "estimator": estimator,
                "seed": 0,
                "quantity": "elevation",
                "unit": "deg",
                "time_s": t[k],
                "estimate": np.nan if 400 < k < 430 else estimate[k],
                "std": std[k],
                "truth": truth[k],
            }


def figures(found: Results) -> Sequence[Figure]:
    """Draw time series, a path on paper, a sweep with error bars, and two columns."""
    one = {"estimator": "ekf", "quantity": "elevation"}
    truth = found.lines(TRUTH, truth=True, **one)
    lines = [found.lines(name, **{**one, "estimator": name}) for name in ("ekf", "mhe")]
    drawn = [line for line in (*lines, truth) if line is not None]
    if not drawn:
        return []
    angle = Panel("Elevation", "time (s)", "elevation (deg)", drawn)
    reference = drawn[-1].y
    errors = [Line(d.name, d.x, d.y - reference, d.std) for d in drawn[:-1]]
    error = Panel("Its error", "time (s)", "error (deg)", errors)
    s = np.linspace(0, 2 * np.pi, 1500)
    path = [
        Line(TRUTH, 30 * np.cos(s), 12 * np.sin(2 * s)),
        Line("mhe", 30 * np.cos(s) + 0.3 * np.sin(40 * s), 12 * np.sin(2 * s) + 0.4),
    ]
    x = np.array([0.0, 10, 20, 30, 45, 60])
    sweep = [
        Line(name, x, y := 0.4 + k * x**1.5 / 60, low=y * 0.8, high=y * 1.3, style=style)
        for name, k, style in (("ekf", 1.0, "line"), ("mhe", 0.2, "points"))
    ]
    noise = 10 ** np.linspace(-3, 0, 7)
    logs = [
        Line("compensated", noise, 3 * noise, 0.8 * noise),
        Line("raw", noise, 9 * noise**0.7, style="dashed"),
    ]
    return [
        Figure(
            "pen-elevation",
            "Elevation of a handwritten stroke",
            "Accelerometer and gyroscope, seed 0. Bands are ±2σ as the estimator claims them; "
            "the gap is a second without samples.",
            [angle, error],
        ),
        Figure(
            "pen-path",
            "The tip on the paper",
            "Camera, accelerometer and gyroscope. One unit is as long on both axes.",
            [Panel("Path", "x (mm)", "y (mm)", path, equal=True)],
        ),
        Figure(
            "pen-sweep",
            "Initial error and noise",
            "Error bars are 95 % intervals over the seeds.",
            [
                Panel("Start", "initial error (deg)", "time to 2° (s)", sweep),
                Panel("Noise", "noise / (m/s²)", "RMSE (deg)", logs, x_log=True, y_log=True),
            ],
            columns=2,
        ),
    ]


def nasty_figures(found: Results) -> Sequence[Figure]:
    """Draw what has markup in every label."""
    line = Line(NASTY[0], np.arange(4.0), np.array([1.0, np.nan, np.inf, 2.0]))
    other = Line(NASTY[1], np.arange(4.0), np.arange(4.0), std=np.ones(4))
    panel = Panel(NASTY[2], NASTY[0], NASTY[1], [line, other])
    return [Figure(NASTY[1], NASTY[0], NASTY[2], [panel])]


def suites(folder: Path) -> list[Suite]:
    """Return the suites of `results`, with one that has no data; their claims go to a folder."""

    def no_tasks(scope: Scope) -> list[Task]:
        return []

    def no_run(task: Task, scope: Scope) -> Outcome:
        return failed("never run")

    texts = {"pen": CLAIMS, "nasty": NASTY_CLAIMS, "real": CLAIMS}
    for name, text in texts.items():
        (folder / f"{name}.toml").write_text(text, "utf-8")
    pen, nasty, real = (folder / f"{name}.toml" for name in texts)
    return [
        Suite(
            "pen",
            "Pen on a turntable",
            "Which of accelerometer and gyroscope does a pen need? A table turns a pen about "
            "two axes; we write ten motions with it. Then the same question at the speed of "
            "handwriting.",
            no_tasks,
            no_run,
            pen,
            figures,
            reads=lambda task: "",
        ),
        Suite(
            "nasty", NASTY[0], NASTY[1], no_tasks, no_run, nasty, nasty_figures,
            reads=lambda task: "somewhere", tables=lambda found: [long_table()],
        ),
        Suite(
            "real",
            "Real recordings",
            "What does a pen on a desk say?",
            no_tasks,
            no_run,
            real,
            lambda found: [],
            missing=lambda scope: "No data given: see --data." if scope.data is None else "",
        ),
    ]  # fmt: skip


def long_table() -> Table:
    """Return a table with whatever labels there may be."""
    rows = [(f"row {k} of {NASTY[0]}", NASTY[1]) for k in range(42)]
    return f"Rows {NASTY[2]}", f"In order of {NASTY[0]}.", (NASTY[2], NASTY[0]), rows


RUN: dict[str, Any] = {
    "command": "pen-mhe benchmark --output results --seeds 5 --jobs 2",
    "suites": ["pen", "nasty", "real"],
    "seeds": 5,
    "code": "0123456789abcdef",
    "versions": {"python": "3.11.2", "casadi": "3.7.0", "numpy": "2.4.6"},
    "machine": {"processor": "A processor", "system": "Linux x86_64", "cores": 2},
    "git": {"commit": "91b6d83", "dirty": True},
    "sessions": [
        {"started": "2026-01-01T00:00:00+00:00", "seconds": 100.5, "jobs": "2", "tasks": 80},
        {"started": "2026-01-01T00:05:00+00:00", "seconds": 61.0, "jobs": "2", "tasks": 60},
    ],
    NASTY[0]: NASTY[1],
}
"""As ``run.json`` has it."""
