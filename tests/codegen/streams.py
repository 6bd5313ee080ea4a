"""Two exports of one estimator side by side: how far single precision is from double."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from codegen.constant_readings import constant_sensors
from codegen.exported import Exported
from models.arrays import Array

SETTLES = 200
"""Samples after which it no longer shows that one step was linearised elsewhere."""


@dataclass
class Deviation:
    """What was seen of single precision, in standard deviations of double precision.

    Parameters
    ----------
    mean : largest deviation of a mean's entry at every step that was looked at
    but_biases : the same without biases, which hardly walk and remember their first seconds
    std : largest relative deviation of a standard deviation
    std_parted : the same where the two have lately kept the factors of different stages: one was
        within rounding of the threshold
    parted : steps at which that happened
    eigenvalue : smallest of all correlation matrices in single precision
    statuses : steps whose statuses differ
    """

    mean: list[float] = field(default_factory=list)
    but_biases: list[float] = field(default_factory=list)
    std: float = 0.0
    std_parted: float = 0.0
    parted: int = 0
    eigenvalue: float = np.inf
    statuses: int = 0


def compare(
    single: Exported, double: Exported, stream: Iterable[tuple[float, Array]], every: int = 1
) -> Deviation:
    """Run both over times and readings; look at every so many steps."""
    model, blocks, n_x = double.model, double.layout.slices, double.model.n_x
    seen, moves = Deviation(), np.array(["_bias" not in name for name in model.state_names])
    single.init()
    double.init()
    kept_a, kept_b = kept_stages(single), kept_stages(double)
    parted = -SETTLES
    for k, (time_s, y) in enumerate(stream):
        single.take(time_s, y)
        double.take(time_s, y)
        if kept_a() != kept_b():
            parted, seen.parted = k, seen.parted + 1
        if k % every:
            continue
        a, b = single.told(), double.told()
        P_a, P_b = (told[blocks["covariance"]].reshape(n_x, n_x) for told in (a, b))
        std_a, std_b = np.sqrt(np.diag(P_a)), np.sqrt(np.diag(P_b))
        difference = model.difference(a[blocks["mean"]], b[blocks["mean"]])
        away = np.abs(np.asarray(difference).ravel()) / std_b
        seen.mean.append(float(away.max()))
        seen.but_biases.append(float(away[moves].max()))
        off = float(np.abs(std_a / std_b - 1).max())
        if k - parted < SETTLES:
            seen.std_parted = max(seen.std_parted, off)
        else:
            seen.std = max(seen.std, off)
        smallest = float(np.linalg.eigvalsh(P_a / np.outer(std_a, std_a)).min())
        seen.eigenvalue = min(seen.eigenvalue, smallest)
        seen.statuses += int(a[blocks["status"]].item() != b[blocks["status"]].item())
    return seen


def kept_stages(export: Exported) -> Callable[[], int]:
    """Return what tells how many stages kept their factors in the last step; 0 for an EKF."""
    layout, real = export.exported.loop.memory, np.ctypeslib.as_ctypes_type(export.dtype)
    if "stayed" not in layout.shapes:
        return lambda: 0
    constants = max(len(constant_sensors(export.model)), 1)

    class State(ctypes.Structure):
        """As the template of the header declares it."""

        _fields_ = (
            ("times", ctypes.c_double * (3 + constants)),
            ("started_and_at", ctypes.c_int * 2),
            ("memory", real * layout.size * 2),
        )

    state = State.from_buffer(export.state)
    at = layout.slices["stayed"].start
    return lambda: int(state.memory[state.started_and_at[1]][at])
