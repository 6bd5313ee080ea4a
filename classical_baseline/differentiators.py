"""Differentiators as data: weights of neighbouring samples, and how many lie in the future.

    ẋ_k ≈ Σ_j w_j x_{k + ahead - j} / Δt,   j = 0 … points - 1

An estimator never sees a measurement that has not arrived yet. A differentiator that looks
ahead is there to show what that would be worth, and says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.signal import savgol_coeffs

from models.arrays import Array
from models.errors import InputError


@dataclass(frozen=True)
class Differentiator:
    """A differentiator.

    Parameters
    ----------
    label : for people
    weights : of the samples, the newest first, for a step of 1
    ahead : number of samples that it uses from the future; 0 is causal

    Raises
    ------
    InputError
        If it looks farther ahead than it has points.
    """

    label: str
    weights: tuple[float, ...]
    ahead: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.ahead < len(self.weights):
            raise InputError(
                f"differentiator {self.label} looks {self.ahead} samples ahead, "
                f"expected 0 to {len(self.weights) - 1}"
            )

    def __call__(self, values: Array, step_s: float) -> Array:
        """Return the derivative (n,) of even samples (n,), NaN where samples are missing."""
        derivative = np.full(len(values), np.nan)
        before = len(self.weights) - 1 - self.ahead
        if len(values) >= len(self.weights):
            inner = np.convolve(values, self.weights, mode="valid") / step_s
            derivative[before : len(values) - self.ahead] = inner
        return derivative


def savitzky_golay(points: int, order: int, ahead: int) -> Differentiator:
    """Return the slope of a polynomial fitted to the last samples.

    Parameters
    ----------
    points : fitted; more is smoother and blurs, or lags if causal with a low order
    order : of the polynomial; higher follows turns and takes up more noise
    ahead : samples in the future; 0 is causal, (points - 1) / 2 is centred, which has the
        least noise

    Raises
    ------
    InputError
        If the order is not from 1 to points - 1.

    References
    ----------
    Savitzky, Golay (1964), Analytical Chemistry 36(8), 1627-1639.
    """
    if not 1 <= order < points:
        raise InputError(
            f"Savitzky-Golay of order {order} over {points} points, "
            "expected an order from 1 to points - 1"
        )
    weights = savgol_coeffs(points, order, deriv=1, pos=points - 1 - ahead, use="conv")
    place = "causal" if ahead == 0 else f"looks {ahead} samples ahead"
    return Differentiator(
        f"Savitzky-Golay, {points} points, order {order}, {place}",
        tuple(float(weight) for weight in weights),
        ahead,
    )


DIFFERENTIATORS: Mapping[str, Differentiator] = MappingProxyType(
    {
        "backward": Differentiator("backward difference", (1.0, -1.0)),
        "central": Differentiator("central difference, looks 1 sample ahead", (0.5, 0.0, -0.5), 1),
        "savitzky-golay": savitzky_golay(15, 2, 0),
        "savitzky-golay-31": savitzky_golay(31, 3, 0),
        "savitzky-golay-centred": savitzky_golay(15, 2, 7),
    }
)
"""Name → differentiator."""
