"""Two exports of one estimator side by side: how far single precision is from double."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from codegen.exported import Exported
from models.arrays import Array


@dataclass
class Deviation:
    """What was seen of single precision, in standard deviations of double precision.

    Parameters
    ----------
    mean : largest deviation of a mean's entry at every step that was looked at
    std : largest relative deviation of a standard deviation
    eigenvalue : smallest of all correlation matrices in single precision
    statuses : steps whose statuses differ
    """

    mean: list[float] = field(default_factory=list)
    std: float = 0.0
    eigenvalue: float = np.inf
    statuses: int = 0


def compare(
    single: Exported, double: Exported, stream: Iterable[tuple[float, Array]], every: int = 1
) -> Deviation:
    """Run both over times and readings; look at every so many steps."""
    model, blocks, n_x = double.model, double.layout.slices, double.model.n_x
    seen = Deviation()
    single.init()
    double.init()
    for k, (time_s, y) in enumerate(stream):
        single.take(time_s, y)
        double.take(time_s, y)
        if k % every:
            continue
        a, b = single.told(), double.told()
        P_a, P_b = (told[blocks["covariance"]].reshape(n_x, n_x) for told in (a, b))
        std_a, std_b = np.sqrt(np.diag(P_a)), np.sqrt(np.diag(P_b))
        difference = model.difference(a[blocks["mean"]], b[blocks["mean"]])
        seen.mean.append(float((np.abs(np.asarray(difference).ravel()) / std_b).max()))
        seen.std = max(seen.std, float(np.abs(std_a / std_b - 1).max()))
        smallest = float(np.linalg.eigvalsh(P_a / np.outer(std_a, std_a)).min())
        seen.eigenvalue = min(seen.eigenvalue, smallest)
        seen.statuses += int(a[blocks["status"]].item() != b[blocks["status"]].item())
    return seen
