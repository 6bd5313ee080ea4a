"""Check: are accelerometer and gyroscope of one clock?

The lag τ of the gyroscope is where gravity's turning fits best: Δ = r(τ), linear in τ over a few
hundredths of a second (`recordings.checks.turns`).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.arrays import Array
from recordings.checks.axes_fit import CANDIDATES
from recordings.checks.handedness import LEAST_CORRELATION, wrong_axes
from recordings.checks.looked import Looked, Pair
from recordings.checks.turns import gravity_turns
from recordings.finding import Finding

STEP_S = 0.02
"""Over which r is differentiated."""
ROUNDS = 3
LONGEST_S = 0.3
LEAST_S, LEAST_STEPS = 0.015, 3.0
"""A lag is at least so long, and so many intervals of the slower sensor."""
FEWEST = 6
"""Windows."""
ERRORS = 6.0
HUBER = 1.5


def check_lag(looked: Looked) -> Iterator[Finding]:
    """Find gyroscopes whose stamps are late or early against an accelerometer's."""
    for pair in looked.pairs:
        if pair.fit is None or pair.fit.correlation[pair.fit.best] < LEAST_CORRELATION:
            continue
        found = lag_of(looked, pair)
        if found is None:
            continue
        lag_s, std_s = found
        interval_s = max(float(np.median(looked.steps_of(n)[1])) for n in (pair.force, pair.rate))
        if abs(lag_s) < max(LEAST_S, LEAST_STEPS * interval_s, ERRORS * std_s):
            continue
        yield Finding(
            f"its stamps are {1e3 * abs(lag_s):.0f} ± {1e3 * std_s:.0f} ms "
            f"{'after' if lag_s > 0 else 'before'} those of {pair.force}, as gravity turns",
            pair.rate,
            0.9,
            f"{'subtract' if lag_s > 0 else 'add'} {1e3 * abs(lag_s):.0f} ms "
            f"{'from' if lag_s > 0 else 'to'} its times, or record both on one clock",
        )


def lag_of(looked: Looked, pair: Pair) -> tuple[float, float] | None:
    """Return by how much a gyroscope's stamps are late, s, and its standard error."""
    assert pair.fit is not None
    way = wrong_axes(pair.fit) or 0
    P, bias = CANDIDATES[way].ravel(), pair.fit.bias[way]
    force, rate = looked.forces[pair.force], looked.rates[pair.rate]
    lag_s, std_s, here = 0.0, np.inf, pair.turns
    for _ in range(ROUNDS):
        early, late = (
            gravity_turns(*force, *rate, lag_s=lag_s + shift) for shift in (-STEP_S, STEP_S)
        )
        shared = sorted(set(early.start_s) & set(here.start_s) & set(late.start_s))
        if len(shared) < FEWEST:
            return None
        first, middle, last = (
            one.some(np.isin(one.start_s, shared)) for one in (early, here, late)
        )
        missing = middle.turned - middle.by_axes @ P - middle.by_bias @ bias
        slope = (last.by_axes - first.by_axes) @ P / (2 * STEP_S)
        step_s, std_s = _step(missing, slope)
        lag_s = float(np.clip(lag_s + step_s, -LONGEST_S, LONGEST_S))
        if abs(step_s) < LEAST_S / 2:
            break
        here = gravity_turns(*force, *rate, lag_s=lag_s)
    return lag_s, std_s


def _step(missing: Array, slope: Array) -> tuple[float, float]:
    """Return the robust fit of missing (w, 3) by slope (w, 3), and its standard error."""
    weight, step = np.ones((len(missing), 1)), 0.0
    for _ in range(6):
        whole = float((weight * slope**2).sum()) + np.finfo(float).tiny
        step = float((weight * slope * missing).sum()) / whole
        left = np.linalg.norm(missing - step * slope, axis=1, keepdims=True)
        weight = 1 / np.maximum(left / (HUBER * np.median(left) + np.finfo(float).tiny), 1.0)
    score = (weight * slope * (missing - step * slope)).sum(axis=1)
    return step, float(np.sqrt(2 * np.sum(score**2))) / whole
