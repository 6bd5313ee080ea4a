"""The cases of the suite as data: when frames arrive, how many there are, what is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from suites.real.ingredients import INGREDIENTS

CAMERA_RATES_HZ = (30, 15, 10, 6, 5, 3)
"""Each divides the recorded rate."""

WITHOUT_RATES_HZ = (30, 10, 3)
"""Camera rates at which ingredients are left out in turn."""

AWAY_S = 0.5
"""How long the camera looks away."""


@dataclass(frozen=True)
class RealCase:
    """How a recording is used.

    Parameters
    ----------
    rate_hz : of the camera
    causal : whether frames are used when they arrive, or at their capture already
    without : the ingredient of the pen that is left out; empty for none
    away_s : how long the camera looks away, once, at a time that the seed chooses
    """

    rate_hz: int
    causal: bool = True
    without: str = ""
    away_s: float = 0.0


CAUSAL: Mapping[str, RealCase] = MappingProxyType(
    {f"causal, {rate} Hz": RealCase(rate) for rate in CAMERA_RATES_HZ}
)
ZERO_DELAY: Mapping[str, RealCase] = MappingProxyType(
    {f"zero delay, {rate} Hz": RealCase(rate, causal=False) for rate in CAMERA_RATES_HZ}
)
WITHOUT: Mapping[str, RealCase] = MappingProxyType(
    {
        f"causal, {rate} Hz, no {name}": RealCase(rate, without=name)
        for name in INGREDIENTS
        for rate in WITHOUT_RATES_HZ
    }
)
AWAY = f"camera away for {AWAY_S:g} s"
CASES: Mapping[str, RealCase] = MappingProxyType(
    {**CAUSAL, **ZERO_DELAY, **WITHOUT, AWAY: RealCase(max(CAMERA_RATES_HZ), away_s=AWAY_S)}
)
"""Case → how the recording is used with a camera."""

NO_CAMERA, UNBIASED = "no camera", "no camera, accelerometer taken as unbiased"

CAMERA_ALONE, INERTIAL, BEST = "camera", "accel+gyro+camera", "accel+gyro+camera+contact"
WITH_CAMERA: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        name: tuple(name.split("+"))
        for name in (CAMERA_ALONE, "accel+camera", "gyro+camera", INERTIAL, BEST)
    }
)
WITHOUT_CAMERA: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {name: tuple(name.split("+")) for name in ("accel", "gyro", "accel+gyro")}
)
"""Configuration → sensors of the pen file."""

HORIZON, LAG = 26, 14
"""Intervals of a window, and samples of the accelerometer, of the estimates that look back."""
