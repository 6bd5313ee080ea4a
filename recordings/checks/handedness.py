"""Check: does gravity turn in the accelerometer as the gyroscope says?

The correlation between both is near 1 where signs and axes are right, near -1 where the
gyroscope's sign is flipped, near 0 where axes are swapped: see `recordings.checks.axes_fit`.
Turning all signs of the accelerometer changes nothing here: `recordings.checks.mounting` sees it.
A gyroscope turned by P against the accelerometer, and an accelerometer whose axes are -P of the
true ones, read the same: both are said.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from recordings.checks.axes_fit import CANDIDATES, AxesFit
from recordings.checks.axes_words import turned_axes, what_is_wrong
from recordings.checks.looked import Looked, Pair
from recordings.checks.mountings import matrix_text
from recordings.finding import Finding, Severity

LEAST_CORRELATION = 0.85
"""Of the axes that fit best."""
BETTER = 4.0
"""Times what the axes that fit best leave unexplained, 1 - ρ², that the axes as they are leave."""
ERRORS = 1.8
"""Standard errors by which the axes as they are cost more."""
AS_GOOD = 1.0
"""Standard errors within which another way fits as well: the plainest of them is taken."""


def check_handedness(looked: Looked) -> Iterator[Finding]:
    """Find gyroscopes and accelerometers whose signs or axes contradict each other."""
    wrong = {id(pair): way for pair in looked.pairs if (way := wrong_axes(pair.fit)) is not None}
    for pair in looked.pairs:
        if id(pair) not in wrong or pair.fit is None:
            continue
        agree = [p for p in looked.pairs if id(p) not in wrong and p.fit is not None]
        if any(other.rate == pair.rate for other in agree):
            yield _of_force(looked, pair, wrong[id(pair)])  # the gyroscope fits another one
        elif pair.force == next(p.force for p in looked.pairs if p.rate == pair.rate):
            yield _of_rate(looked, pair, wrong[id(pair)])


def wrong_axes(fit: AxesFit | None) -> int | None:
    """Return in which way of `CANDIDATES` axes lie; None where they are right, or nobody knows."""
    if fit is None:
        return None
    best = fit.best
    if fit.worse_by(0, best) < ERRORS or fit.correlation[best] < LEAST_CORRELATION:
        return None
    if fit.unexplained(0) < BETTER * fit.unexplained(best):
        return None
    return max(fit.alike(AS_GOOD), key=_plainness)


def _plainness(way: int) -> tuple[float, float]:
    """Return how likely a mistake is: all signs, then one of them, then two axes swapped."""
    matrix = CANDIDATES[way]
    if np.array_equal(matrix, -np.eye(3)):
        return 2.0, 0.0
    return 1.0, float(max(np.trace(matrix), np.trace(-matrix)))


def _of_rate(looked: Looked, pair: Pair, way: int) -> Finding:
    fit, P = pair.fit, CANDIDATES[way]
    assert fit is not None
    mounted = np.array(looked.inertial[pair.rate].sensor_to_body)
    own = _signed(mounted.T @ P @ mounted)
    axes = ", ".join(turned_axes(own))
    what = (
        f"{what_is_wrong(own)}: gravity in {pair.force} turns with a correlation of "
        f"{fit.correlation[0]:.2f} to its rates, of {fit.correlation[way]:.2f} once they are "
        f"({axes}) of what it reads"
    )
    if np.linalg.det(P) > 0:
        mirrored = _in_own_axes(looked, pair.force, -P)
        remedy = (
            f"it is mounted otherwise than {pair.force}; in the pen file\n"
            f"[sensors.{pair.rate}]\nsensor_to_body = {matrix_text(P @ mounted)}\n"
            f"or, read alike, {pair.force} is wrong and its axes are "
            f"({', '.join(turned_axes(mirrored))}) of what it reads"
        )
    else:
        remedy = columns_remedy(looked, pair.rate, own)
    return Finding(what, pair.rate, 0.98, remedy, Severity.NOT_MEANT)


def _of_force(looked: Looked, pair: Pair, way: int) -> Finding:
    """Return what is wrong of an accelerometer whose gyroscope fits another one."""
    fit, P = pair.fit, CANDIDATES[way]
    assert fit is not None
    # f read otherwise by Q turns as the gyroscope by det(Q) Qᵀ would.
    Q = np.linalg.det(P) * P.T
    own = _in_own_axes(looked, pair.force, Q)
    mounted = np.array(looked.inertial[pair.force].sensor_to_body)
    what = (
        f"{what_is_wrong(own)}: gravity turns in it otherwise than {pair.rate} says, and than in "
        "another accelerometer"
    )
    remedy = columns_remedy(looked, pair.force, own)
    if np.linalg.det(Q) > 0:
        remedy = (
            f"in the pen file\n[sensors.{pair.force}]\nsensor_to_body = {matrix_text(Q @ mounted)}"
        )
    return Finding(what, pair.force, 0.95, remedy, Severity.NOT_MEANT)


def columns_remedy(looked: Looked, name: str, own: Array) -> str:
    """Return how a sensor's columns are read with other signs or in another order."""
    columns = ",".join(turned_axes(own, looked.columns_of(name))).replace("--", "")
    return f'read its columns as --columns "{name}={columns}", or mend the logger'


def _in_own_axes(looked: Looked, name: str, in_body: Array) -> Array:
    mounted = np.array(looked.inertial[name].sensor_to_body)
    return _signed(mounted.T @ in_body @ mounted)


def _signed(matrix: Array) -> Array:
    """Return the nearest signed permutation."""
    return np.asarray(max(CANDIDATES, key=lambda one: float(np.sum(one * matrix))))
