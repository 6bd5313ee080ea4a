"""What noise levels are judged by, a row of `OBJECTIVES` each: smaller is better.

    innovations      -log likelihood, Σ ½ (vᵀ S⁻¹ v + log det 2πS), of what is measured
    flatness         spread of the tip about a plane, while it presses: the geometric mean of
                     those with every first, third and tenth frame of the camera
    without-camera   mean of ½ (e²/s² + log s²), elevation in gaps of the camera against the
                     frames that are withheld; s² is what is claimed and the frame's own noise

No one of them is right for all: the likelihood trusts a camera more than it deserves, because
errors that stay for many frames look like motion; flatness does not see how a hand moves; gaps
do not see how the pen turns, which the gyroscope does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from estimation.estimate import EstimateHistory
from models.arrays import Array
from models.errors import InputError
from models.pen_config import PenConfig
from pen_mhe.tuning.gaps import camera_elevation, gap_passes
from pen_mhe.tuning.parameters import Parameter
from pen_mhe.tuning.parts import ScoredPart

FEWEST_TOUCHES = 30
FEWEST_FRAMES = 30
EVERY, SLOWEST_HZ = (1, 3, 10), 2.5
"""Flatness is judged with every so many-th frame too, down to a rate: with all frames alone, the
biases of a short recording are fitted to its noise."""


class Filter(Protocol):
    """Runs the EKF of a pen; `pen_mhe.tuning.levels.LevelFilter.history`."""

    def __call__(
        self, pen: PenConfig, time_s: Array, y: Array, *, covariances: bool = False
    ) -> EstimateHistory:
        """Return what it says of stacked readings."""


@dataclass(frozen=True)
class Score:
    """Of one pen on one part of a recording.

    Parameters
    ----------
    value : smaller is better, in the objective's unit; inf where the filter broke down
    figures : name with its unit → number, for people
    """

    value: float
    figures: Mapping[str, float]


Judge = Callable[[Filter, PenConfig], Score]


@dataclass(frozen=True)
class Objective:
    """A row of `OBJECTIVES`.

    Parameters
    ----------
    judge : of a part of a recording; raises `InputError` where its data are absent
    unit : of its value
    loss : of the value of an optimum: how much worse is as good as it
    loss_text : the same in words
    proposes : whether it is good for a parameter, of sensors with a camera or without
    withholds_touch : whether contact may not be among the sensors
    """

    judge: Callable[[ScoredPart], Judge]
    unit: str
    loss: Callable[[float], float]
    loss_text: str
    proposes: Callable[[Parameter], bool]
    withholds_touch: bool = False


def log_likelihood(history: EstimateHistory, rows: NDArray[np.bool_]) -> float:
    """Return Σ log N(v; 0, S) over the innovations of a history that kept its covariances.

    Parameters
    ----------
    rows : (n_r,) those that count
    """
    v, S = history.innovation[:, rows], history.innovation_covariance[:, rows][:, :, rows]
    present = ~np.isnan(v)
    some = present.any(axis=1)
    v, S, present = v[some], S[some], present[some]
    both = present[:, :, None] & present[:, None, :]
    S = np.where(both, S, np.eye(S.shape[1]))
    v = np.where(present, v, 0.0)
    try:
        L = np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        return -math.inf
    e = np.linalg.solve(L, v[:, :, None])
    log_det = 2 * np.log(np.diagonal(L, axis1=1, axis2=2)).sum()
    return -0.5 * float((e**2).sum() + log_det + present.sum() * math.log(2 * math.pi))


def _innovations(part: ScoredPart) -> Judge:
    time_s, y = part.stacked

    def judged(run: Filter, pen: PenConfig) -> Score:
        history = run(pen, time_s, y, covariances=True).between(part.counts_from_s)
        rows = part.model.measured_rows
        found = log_likelihood(history, rows)
        squared = history.squared_innovations[:, list(history.row_sets).index("measured")]
        count = (~np.isnan(history.innovation[:, rows])).sum()
        nis = float(np.nansum(squared) / count)
        return Score(_finite(-found), {"log likelihood": found, "NIS per row": nis})

    return judged


def plane_spread_m(tip: Array) -> float:
    """Return the root mean square distance in height of points (m, 3) from a plane fitted to them.

    The plane may slope: a desk that is not level is no error.
    """
    design = np.column_stack([np.ones(len(tip)), tip[:, :2] - tip[:, :2].mean(axis=0)])
    plane, *_ = np.linalg.lstsq(design, tip[:, 2], rcond=None)
    return float(np.sqrt(np.mean((tip[:, 2] - design @ plane) ** 2)))


def _flatness(part: ScoredPart) -> Judge:
    touches = part.touches_s
    if len(touches) < FEWEST_TOUCHES:
        raise InputError(
            f"recording {part.recording.name}: the tip touches at {len(touches)} counted "
            f"instants, expected at least {FEWEST_TOUCHES} (a contact sensor in pen file and "
            "recording) to tell how flat it stays"
        )
    if not part.cameras:
        raise InputError("objective flatness without a camera: nothing then sees the tip's height")
    time_s, _ = part.stacked
    rows = np.searchsorted(time_s, touches, side="right") - 1
    runs = {f"height spread mm, {rate_hz:.3g} Hz": y for rate_hz, y in _thinned(part)}

    def judged(run: Filter, pen: PenConfig) -> Score:
        figures = {}
        for name, y in runs.items():
            history = run(pen, time_s, y)
            tip = np.column_stack([history.column(f"tip_{axis}_m") for axis in "xyz"])[rows]
            figures[name] = 1e3 * plane_spread_m(tip) if np.isfinite(tip).all() else math.inf
        return Score(math.exp(np.mean(np.log(list(figures.values())))), figures)

    return judged


def _thinned(part: ScoredPart) -> Iterator[tuple[float, Array]]:
    """Yield camera rates, and the readings (n, n_y) with so many frames: all first."""
    time_s, _ = part.stacked
    for every in EVERY:
        hidden = np.zeros(len(time_s), dtype=bool)
        slowest = math.inf
        for camera in part.cameras:
            at, _ = part.frames(camera)
            slowest = min(slowest, (len(at) - 1) / max(time_s[-1] - time_s[0], 1e-9) / every)
            hidden[at[np.arange(len(at)) % every != 0]] = True
        if every == 1 or slowest >= SLOWEST_HZ:
            yield slowest, part.without([camera.name for camera in part.cameras], hidden)


def _without_camera(part: ScoredPart) -> Judge:
    cameras = part.cameras
    if not cameras:
        raise InputError("objective without-camera: no camera is among the sensors to withhold")
    if not any(s.constant_reading is None and not s.sees_pose for s in part.model.sensors):
        raise InputError("objective without-camera: no other sensor is left when it is withheld")
    names = [camera.name for camera in cameras]
    time_s, _ = part.stacked
    passes = []
    for gaps in gap_passes(part.counts_from_s, float(time_s[-1])):
        hidden = np.any([(time_s >= low) & (time_s < high) for low, high in gaps], axis=0)
        rows, seen, noise = [], [], []
        for camera in cameras:
            at, frames = part.frames(camera)
            at, frames = at[hidden[at]], frames[hidden[at]]
            turned = part.pen.sensors[camera.name].sensor_to_body  # type: ignore[attr-defined]
            is_turn = [unit == "rad" for unit in camera.unit_of_row]
            rows.append(at)
            seen.append(camera_elevation(frames, np.array(turned)))
            noise.append(np.full(len(at), camera.noise_std[is_turn].max()))
        joined = (np.concatenate(each) for each in (rows, seen, noise))
        passes.append((part.without(names, hidden), *joined))
    if sum(len(at) for _, at, _, _ in passes) < FEWEST_FRAMES:
        raise InputError(
            f"recording {part.recording.name}: fewer than {FEWEST_FRAMES} frames of "
            f"{', '.join(names)} to withhold, expected more"
        )

    def judged(run: Filter, pen: PenConfig) -> Score:
        errors, claims, noises = [], [], []
        for y, at, seen, noise in passes:
            history = run(pen, time_s, y)
            errors.append(history.column("elevation_rad")[at] - seen)
            claims.append(history.std_of("elevation_rad")[at])
            noises.append(noise)
        e, claimed, own = (np.concatenate(parts) for parts in (errors, claims, noises))
        variance = claimed**2 + own**2
        value = float(np.mean(0.5 * (e**2 / variance + np.log(variance))))
        return Score(
            _finite(value),
            {
                "nats per frame": value,
                "elevation rms deg": math.degrees(float(np.sqrt(np.mean(e**2)))),
                "rms (error / claimed)": float(np.sqrt(np.mean(e**2 / variance))),
            },
        )

    return judged


def _finite(value: float) -> float:
    return value if math.isfinite(value) else math.inf


OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        "innovations": Objective(
            _innovations,
            "nats",
            lambda value: 2.0,
            "2 nats",
            lambda parameter: not parameter.sees_pose,
        ),
        "flatness": Objective(
            _flatness,
            "mm",
            lambda value: 0.01 * value,
            "1 % of the spread",
            lambda parameter: parameter.sees_pose or parameter.kind == "walk",
            withholds_touch=True,
        ),
        "without-camera": Objective(
            _without_camera,
            "nats per frame",
            lambda value: 0.02,
            "0.02 nats per frame",
            lambda parameter: parameter.table == ("motion", "tip"),
        ),
    }
)
"""Name → what it is; `proposes` names the parameters that it is good for."""
