"""The figures of the suite, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.tasks.results import Results
from benchmark.tasks.task import OK
from classical_baseline.weight_search import CURVE_WEIGHTS, INTERVAL
from models.arrays import Array
from suites.tilt.cases import CURVE_CASES, FULL_TURN, TWO_AXES
from suites.tilt.estimators import ACCELEROMETER, CURVE
from suites.tilt.operations import uncounted
from suites.tilt.samples import case_named

ONE_AXIS = "swing, one axis"
SHOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        FULL_TURN: (
            ACCELEROMETER,
            "fixed-weight",
            "fixed-weight-best",
            "fixed-weight-previous",
            "ekf",
        ),
        ONE_AXIS: ("fixed-weight", "fixed-weight-best", "ekf"),
        TWO_AXES: ("fixed-weight", "fixed-weight-best", "fixed-weight-carried", "ekf"),
    }
)
"""Case → estimators whose series figures show."""

BY_COST = (
    ACCELEROMETER,
    "fixed-weight",
    "fixed-weight-searched",
    "fixed-weight-best",
    *BENCHMARK_ESTIMATORS,
)
COST_CASES = (FULL_TURN, TWO_AXES)


def curve_quantity(case: str, weight: float) -> str:
    """Return the name of the error at one weight of a curve."""
    return f"{case_named(case).weighed_by}, w = {weight:g}"


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are rows or series."""
    drawn = (_full_turn(results), _curves(results), _axes(results), _cost(results))
    kept = []
    for figure in drawn:
        panels = [panel for panel in figure.panels if panel.lines]
        if panels:
            kept.append(Figure(figure.key, figure.title, figure.caption, panels, figure.columns))
    return kept


def _full_turn(results: Results) -> Figure:
    """Noise, raw and filtered angle, as the paper plots them."""
    angles = [_series(results, FULL_TURN, TRUTH, "roll")]
    angles += [_series(results, FULL_TURN, name, "roll") for name in SHOWN[FULL_TURN]]
    noise = [_error(results, FULL_TURN, name) for name in (ACCELEROMETER, "fixed-weight")]
    errors = [
        _error(results, FULL_TURN, name) for name in ("fixed-weight", "fixed-weight-best", "ekf")
    ]
    held = [_error(results, FULL_TURN, "fixed-weight-previous")]
    return Figure(
        "tilt-full-turn",
        "Once around: noise, raw and filtered angle",
        "The angle that [Tilt] calls yaw is a tilt: an accelerometer does not see yaw. "
        "fixed-weight has w = 0.25; fixed-weight-best the weight found on other recordings; "
        "fixed-weight-previous the same weight with the sign of the previous z, which holds it "
        "up at 90 and 270 deg. The bands of ekf are two standard deviations.",
        [
            Panel("angle", "time (s)", "roll (deg)", _found(angles)),
            Panel("error, raw and with w = 0.25", "time (s)", "error (deg)", _found(noise)),
            Panel("error, filtered", "time (s)", "error (deg)", _found(errors)),
            Panel("error, sign of the previous z", "time (s)", "error (deg)", _found(held)),
        ],
    )


def _curves(results: Results) -> Figure:
    """RMSE over w, with the end of the published search."""
    panels = []
    for case in CURVE_CASES:
        weights, errors = _curve(results, case)
        if not len(weights):
            continue
        shown = weights > 0  # a logarithmic axis has no zero
        lines = [Line(CURVE, weights[shown], errors[shown])]
        for name in ("fixed-weight-searched", "fixed-weight-convex-searched", "fixed-weight-best"):
            at = _mean(results, case, name, "weight"), _mean(results, case, name, _judged(case))
            if np.isfinite(at).all() and at[0] > 0:
                lines.append(Line(name, np.array(at[:1]), np.array(at[1:]), style="points"))
        # The EKF has no weight: a level to compare with.
        level = _mean(results, case, "ekf", _judged(case))
        if np.isfinite(level):
            ends = weights[shown][[0, -1]]
            lines.append(Line("ekf", ends, np.array([level, level]), style="dashed"))
        panels.append(
            Panel(case, "weight w", f"{_judged(case)} RMSE (deg)", lines, x_log=True, y_log=True)
        )
    low, high = INTERVAL
    ended = results.select(
        estimator="fixed-weight-searched", quantity="search ended, upper bound", status=OK
    )
    cases = ended.groupby("case")["bias"].min() == 1
    return Figure(
        "tilt-weights",
        f"The error over the weight, and where the search over [{low:g}, {high:g}] ends",
        "Mean over seeds. Points: the weights that bisection over the published interval and "
        "the whole curve give over recordings that are not judged. Read as R_acc + w R_g, the "
        "search ended at its upper bound, with the error still falling, in "
        f"{int(cases.sum())} of {len(cases)} cases; read as (1 - w) R_acc + w R_g (drawn at the "
        "weight of the sum) the same interval holds every weight.",
        panels,
        columns=2,
    )


def _axes(results: Results) -> Figure:
    panels = []
    for case in (ONE_AXIS, TWO_AXES):
        lines = [_series(results, case, name, "direction error") for name in SHOWN[case]]
        panels.append(Panel(case, "time (s)", "error (deg)", _found(lines), y_log=True))
    return Figure(
        "tilt-axes",
        "Turning about one axis and about two",
        "The error of the direction of gravity. The recursion turns each projected angle by a "
        "rate of its own, which is right for one "
        "level axis only. fixed-weight-carried has the weight that is best for one full turn.",
        panels,
    )


def _cost(results: Results) -> Figure:
    panels = []
    missing = [uncounted(name) for name in BENCHMARK_ESTIMATORS]
    for case in COST_CASES:
        lines = []
        for name in BY_COST:
            errors = _values(results, case, name, "direction")
            count = _mean(results, case, name, "operations")
            if len(errors) and np.isfinite(count):
                lines.append(
                    Line(
                        name,
                        np.array([count]),
                        np.array([errors.mean()]),
                        low=np.array([errors.min()]),
                        high=np.array([errors.max()]),
                        style="points",
                    )
                )
        panels.append(
            Panel(case, "operations per sample", "direction RMSE (deg)", lines, True, True)
        )
    return Figure(
        "tilt-cost",
        "Accuracy over operations per sample",
        " ".join(
            [
                "Mean over seeds, with the smallest and the largest. An operation is an "
                "instruction of a CasADi function: a sum counts as much as a sine.",
                *filter(None, missing),
            ]
        ),
        panels,
        columns=2,
    )


def _series(results: Results, case: str, name: str, quantity: str) -> Line | None:
    if name == TRUTH:
        for estimator in SHOWN[case]:
            line = results.lines(
                TRUTH, truth=True, case=case, estimator=estimator, quantity=quantity
            )
            if line is not None:
                return line
        return None
    return results.lines(name, case=case, estimator=name, quantity=quantity)


def _error(results: Results, case: str, name: str) -> Line | None:
    """Return the roll's error over time."""
    estimate = _series(results, case, name, "roll")
    truth = results.lines(TRUTH, truth=True, case=case, estimator=name, quantity="roll")
    if estimate is None or truth is None:
        return None
    return Line(name, estimate.x, estimate.y - truth.y, estimate.std)


def _curve(results: Results, case: str) -> tuple[Array, Array]:
    """Return weights and mean errors (n,) of a case, as far as there are any."""
    errors = np.array(
        [_mean(results, case, CURVE, curve_quantity(case, weight)) for weight in CURVE_WEIGHTS]
    )
    there = np.isfinite(errors)
    return np.array(CURVE_WEIGHTS)[there], errors[there]


def _judged(case: str) -> str:
    return case_named(case).weighed_by


def _values(results: Results, case: str, estimator: str, quantity: str) -> Array:
    rows = results.select(case=case, estimator=estimator, quantity=quantity, status=OK)
    return np.asarray(rows["rmse"], dtype=float)


def _mean(results: Results, case: str, estimator: str, quantity: str) -> float:
    values = _values(results, case, estimator, quantity)
    return float(values.mean()) if len(values) else float("nan")


def _found(lines: Sequence[Line | None]) -> list[Line]:
    return [line for line in lines if line is not None]
