"""Check: does a camera see the pen stand and turn as its inertial sensors feel it?

A camera's pose is an attitude C, body to world. So up is Cᵀ e_z in body axes, where an
accelerometer's mean over a second points; and between two frames the pen turned by what
a gyroscope's rates add up to, at the lag where both fit best.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from models.arrays import Array
from recordings.checks.axes_fit import CANDIDATES
from recordings.checks.looked import Looked, Signal
from recordings.checks.mountings import matrix_text
from recordings.finding import Finding, Severity

WINDOW_S = 1.0
FEWEST, FRAMES = 3, 5
"""Windows, and frames in each."""
AS_SEEN, BETTER = 0.97, 0.08
"""Mean cosine between up as felt and as seen in the axes that fit best, and by how much it is
less as they are."""
AS_GOOD = 0.01
STEP_S, LONGEST_STEP_S = 0.2, 0.4
"""Between frames whose attitudes are compared, and at most."""
LAGS_S = np.arange(-0.3, 0.3001, 0.005)
LEAST_LAG_S, ERRORS, FEWEST_STEPS = 0.02, 5.0, 40
LEAST_CORRELATION = 0.85
CLIPPED = 3.0
"""Medians of a residual beyond which it counts no more."""


def check_camera(looked: Looked) -> Iterator[Finding]:
    """Find accelerometers that feel up where no camera sees it, and cameras that are late."""
    for name, sensor in looked.pen.sensors.items():
        times, poses = looked.raw.get(name, (np.zeros(0), np.zeros((0, 6))))
        if not sensor.sees_pose or len(times) < FRAMES:
            continue
        target = Rotation.from_matrix(np.array(sensor.sensor_to_body))  # type: ignore[attr-defined]
        seen = Rotation.from_rotvec(poses[:, 3:]) * target.inv()
        for force, signal in looked.forces.items():
            finding = _stands(looked, name, force, signal, (times, seen.inv().apply([0, 0, 1])))
            if finding is not None:
                yield finding
        for rate, signal in looked.rates.items():
            found = lag_behind(times, seen, *signal)
            if found is not None and abs(found[0]) > max(LEAST_LAG_S, ERRORS * found[1]):
                yield _late(name, rate, *found)


def _stands(looked: Looked, name: str, force: str, felt: Signal, seen: Signal) -> Finding | None:
    ups = [np.array(part) for part in zip(*_windows(felt, seen), strict=True)]
    if not ups or len(ups[0]) < FEWEST:
        return None
    cosines = np.einsum("kab,wb,wa->k", CANDIDATES, ups[0], ups[1]) / len(ups[0])
    best = float(cosines.max())
    if best < AS_SEEN or cosines[0] > best - BETTER:
        return None
    # Where the pen hardly turns, several fit: the one nearest to the pen file's.
    alike = CANDIDATES[cosines > best - AS_GOOD]
    proper = [one for one in alike if np.linalg.det(one) > 0]
    P = max(proper or alike, key=np.trace)
    angle = np.degrees(np.arccos(np.clip(cosines[0], -1.0, 1.0)))
    mounted = P @ np.array(looked.inertial[force].sensor_to_body)
    return Finding(
        f"it feels up {angle:.0f}° from where {name} sees it",
        force,
        0.95,
        "one of the two is mounted otherwise than in the pen file, or a sign is flipped; if it is "
        f"{force}, then in the pen file\n[sensors.{force}]\n"
        f"sensor_to_body = {matrix_text(mounted)}",
        Severity.NOT_MEANT,
    )


def _windows(felt: Signal, seen: Signal) -> Iterator[tuple[Array, Array]]:
    """Yield up as felt and as seen (3,), of windows in which both are told."""
    for start in np.arange(max(felt[0][0], seen[0][0]), min(felt[0][-1], seen[0][-1]), WINDOW_S):
        ups = []
        for times, vectors in (felt, seen):
            first, end = np.searchsorted(times, [start, start + WINDOW_S])
            mean = vectors[first:end].mean(axis=0) if end - first >= FRAMES else np.zeros(3)
            ups.append(mean / (np.linalg.norm(mean) + np.finfo(float).tiny))
        if all(up.any() for up in ups):
            yield ups[0], ups[1]


def lag_behind(
    times: Array, seen: Rotation, rate_time_s: Array, rate: Array
) -> tuple[float, float] | None:
    """Return by how much frames are late against a gyroscope, s, and its standard error.

    None where too little turns, or camera and gyroscope do not agree at any lag.

    Parameters
    ----------
    times, seen : (m,) of frames, and attitudes, body to world
    rate_time_s, rate : (n,), (n, 3) about axes of the body, rad/s
    """
    apart = max(1, round(STEP_S / float(np.median(np.diff(times)))))
    if len(times) < FEWEST_STEPS + apart:
        return None
    starts, ends = times[:-apart], times[apart:]
    steps = ends - starts
    inner = (ends < rate_time_s[-1] + LAGS_S[0]) & (starts > rate_time_s[0] + LAGS_S[-1])
    kept = (steps < LONGEST_STEP_S) & inner
    if kept.sum() < FEWEST_STEPS:
        return None
    turned = (seen[:-apart].inv() * seen[apart:]).as_rotvec()[kept] / steps[kept, None]
    middle = (rate[1:] + rate[:-1]) / 2 * np.diff(rate_time_s)[:, None]
    angle = np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)])

    def told(lag_s: float) -> Array:
        first, last = (
            np.column_stack([np.interp(at[kept] - lag_s, rate_time_s, one) for one in angle.T])
            for at in (starts, ends)
        )
        mean = (last - first) / steps[kept, None]
        return np.asarray(mean - np.median(mean - turned, axis=0))

    costs = np.array([_cost(turned - told(lag_s)) for lag_s in LAGS_S])
    k = int(np.clip(costs.argmin(), 1, len(LAGS_S) - 2))
    bend = costs[k - 1] - 2 * costs[k] + costs[k + 1]
    if bend <= 0:
        return None
    step_s = LAGS_S[1] - LAGS_S[0]
    lag_s = float(LAGS_S[k] + step_s * (costs[k - 1] - costs[k + 1]) / (2 * bend))
    best = told(lag_s)
    spread = np.sqrt(np.sum(turned**2) * np.sum(best**2)) + np.finfo(float).tiny
    if np.sum(turned * best) < LEAST_CORRELATION * spread:
        return None
    noise = costs[k] / turned.size
    return lag_s, float(np.sqrt(2 * apart * noise * step_s**2 / bend))


def _cost(residual: Array) -> float:
    size = np.sum(residual**2, axis=1)
    return float(np.minimum(size, CLIPPED**2 * np.median(size)).sum())


def _late(name: str, rate: str, lag_s: float, std_s: float) -> Finding:
    late = lag_s > 0
    return Finding(
        f"its frames are stamped {1e3 * abs(lag_s):.0f} ± {1e3 * std_s:.0f} ms "
        f"{'after' if late else 'before'} the pen turned, as {rate} says",
        name,
        0.9,
        f"{'subtract' if late else 'add'} that {'from' if late else 'to'} its times, so that they "
        "are those of capture; pen-mhe calibrate camera finds the delay of arrivals",
    )
