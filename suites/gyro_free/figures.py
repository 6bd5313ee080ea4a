"""The figures of the suite, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.tasks.results import Results
from suites.gyro_free.array_task import SHOWN as ARRAY_SHOWN
from suites.gyro_free.cases import INTEGRATED, TEST_CASE
from suites.gyro_free.figure_sweeps import sweeps, where_it_helps
from suites.gyro_free.simulated import PATH_SHOWN, SHOWN

RATES: Mapping[str, str] = MappingProxyType({"rate y": "ωy", "rate z": "ωz"})
"""Quantity of a series → its symbol."""


def figures(results: Results) -> Sequence[Figure]:
    """Return every figure for which there are rows or series."""
    drawn = (
        _rate_errors(results),
        *sweeps(results),
        where_it_helps(results),
        _path(results),
        _array(results),
    )
    return [figure for figure in drawn if any(panel.lines for panel in figure.panels)]


def _rate_errors(results: Results) -> Figure:
    """Figures 3 and 4 of the paper."""
    panels = []
    for before in (True, False):
        shown = [name for names in SHOWN.values() for name in names]
        estimators = [name for name in shown if (name == INTEGRATED) == before]
        for quantity, symbol in RATES.items():
            lines = [_error(results, name, quantity) for name in estimators]
            panels.append(
                Panel(
                    f"{symbol}, {'before' if before else 'after'} compensation",
                    "time (s)",
                    f"error of {symbol} (deg/s)",
                    [line for line in lines if line],
                )
            )
    return Figure(
        "gyro-free-figures-3-4",
        "Rate error before and after compensation (figures 3 and 4 of [GyroFree])",
        "The test case. Above, the difference of the accelerometers integrated; below, with the "
        "compensation inside the integration, beside EKF and MHE with the same sensors, "
        "told as well that the pen does not roll. "
        "gyro-free takes a Savitzky-Golay derivative, gyro-free-backward a plain difference.",
        panels,
        columns=2,
    )


def _error(results: Results, estimator: str, quantity: str) -> Line | None:
    line = _estimate(results, TEST_CASE, estimator, quantity)
    truth = _truth(results, TEST_CASE, estimator, quantity)
    if line is None or truth is None:
        return None
    return Line(estimator, line.x, line.y - truth.y)


def _path(results: Results) -> Figure:
    lines: list[Line] = []
    for estimator in PATH_SHOWN:
        x, y, true_x, true_y = (
            find(results, TEST_CASE, estimator, quantity)
            for find in (_estimate, _truth)
            for quantity in ("path x", "path y")
        )
        if x is None or y is None or true_x is None or true_y is None:
            continue
        if not lines:
            lines.append(Line(TRUTH, true_x.y, true_y.y))
        lines.append(Line(estimator, x.y, y.y))
    return Figure(
        "gyro-free-path",
        "The path of the gesture",
        "The test case from above. A rate error tilts gravity, and a tilt error becomes a path "
        "error that grows with the fourth power of time.",
        [Panel("Path", "X (mm)", "Y (mm)", lines, equal=True)],
    )


def _array(results: Results) -> Figure:
    panels = []
    for case, estimators in ARRAY_SHOWN.items():
        for quantity, symbol in RATES.items():
            lines: list[Line] = []
            for estimator in estimators:
                line = _estimate(results, case, estimator, quantity)
                gyroscopes = _truth(results, case, estimator, quantity)
                if line is None or gyroscopes is None:
                    continue
                lines += [line] if lines else [gyroscopes, line]
            panels.append(Panel(f"{symbol}, {case}", "time (s)", f"{symbol} (deg/s)", lines))
    return Figure(
        "gyro-free-array",
        "A real board by two accelerometers, and by gyroscopes",
        "Above, a board is tilted over an edge from one pose to the next, with a knock at either "
        "end; below, it is taken up and shaken. One pair of its accelerometers 27 mm apart, and "
        "as truth the mean of its eight gyroscopes. The compensation of gyro-free-careful has a "
        "determinant threshold that fits the noise of these sensors.",
        panels,
        columns=2,
    )


def _estimate(results: Results, case: str, estimator: str, quantity: str) -> Line | None:
    return results.lines(estimator, case=case, estimator=estimator, quantity=quantity)


def _truth(results: Results, case: str, estimator: str, quantity: str) -> Line | None:
    return results.lines(TRUTH, True, case=case, estimator=estimator, quantity=quantity)
