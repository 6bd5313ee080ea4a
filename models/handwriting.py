"""Smooth random handwriting: seeded sums of sines in a band, with a falling spectrum.

Every degree of freedom is

    q(t) = centre + Σ_j A_j sin(ω_j t + φ_j)

with one ω_j in each of the equal bins of log-frequency between the ends of the band, random
within its bin, and φ_j random. The amplitude spectral density falls as
f^-fall, so a bin, whose width grows with f, has A_j² ∝ f_j^(1 - 2 fall); they are scaled
to Σ A_j² / 2 = rms². The tip also writes a line along x, to its end and back, so
that a long run stays on the page:

    x(t) += L/2 (1 - cos(π t / T))
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import PositiveFloat, PositiveInt, model_validator

from models.arrays import Array
from models.config import UnitConfig
from models.sensor_kinds.mounted import NonNegative, Vector3


class SineBand(UnitConfig):
    """Where the sines of a degree of freedom lie.

    Parameters
    ----------
    lowest_hz, highest_hz : ends of the band; a higher end is brisker
    fall : exponent of the falling amplitude spectral density; larger is smoother
    sines : their number; more look more random
    """

    lowest_hz: PositiveFloat
    highest_hz: PositiveFloat
    fall: NonNegative = 1.5
    sines: PositiveInt = 24

    @model_validator(mode="after")
    def _in_order(self) -> SineBand:
        if not self.lowest_hz < self.highest_hz:
            raise ValueError(
                f"expected lowest_hz below highest_hz, got {self.lowest_hz:g} and "
                f"{self.highest_hz:g} Hz"
            )
        return self


class Handwriting(UnitConfig):
    """Random handwriting along a line.

    Parameters
    ----------
    description : what it draws
    tip_m, angles_rad : centre of the tip at the begin of the line; azimuth, elevation, spin
    tip_rms_m, angles_rms_rad : RMS of each about it, the line aside
    tip_band, angle_band : their frequencies
    line_m, line_duration_s : L, T: length of the line and time to write it
    """

    kind: Literal["handwriting"] = "handwriting"
    description: str
    tip_m: Vector3 = (0.0, 0.0, 0.0)
    angles_rad: Vector3
    tip_rms_m: tuple[NonNegative, NonNegative, NonNegative]
    angles_rms_rad: tuple[NonNegative, NonNegative, NonNegative]
    tip_band: SineBand
    angle_band: SineBand
    line_m: NonNegative
    line_duration_s: PositiveFloat


def handwriting(
    config: Handwriting, time_s: Array, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Return q, q̇, q̈, each (n, 6), of random handwriting.

    Parameters
    ----------
    time_s : (n,) sampling instants, s
    rng : draws frequencies and phases; the motion is a function of time once they are drawn
    """
    tip = _sines(config.tip_band, config.tip_rms_m, time_s, rng)
    angles = _sines(config.angle_band, config.angles_rms_rad, time_s, rng)
    q, q_dot, q_ddot = (np.hstack(pair) for pair in zip(tip, angles, strict=True))
    rate = np.pi / config.line_duration_s
    half = config.line_m / 2
    q += np.array([*config.tip_m, *config.angles_rad])
    q[:, 0] += half * (1 - np.cos(rate * time_s))
    q_dot[:, 0] += half * rate * np.sin(rate * time_s)
    q_ddot[:, 0] += half * rate**2 * np.cos(rate * time_s)
    return q, q_dot, q_ddot


def _sines(
    band: SineBand, rms: Vector3, time_s: Array, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Return three sums of sines and their two derivatives, each (n, 3)."""
    shape = (3, band.sines)
    position = (np.arange(band.sines) + rng.random(shape)) / band.sines
    frequency = band.lowest_hz * (band.highest_hz / band.lowest_hz) ** position
    phase = rng.uniform(0, 2 * np.pi, shape)
    power = frequency ** (1 - 2 * band.fall)
    power /= power.sum(axis=1, keepdims=True)
    amplitude = np.array(rms)[:, None] * np.sqrt(2 * power)
    omega = 2 * np.pi * frequency
    angle = omega * time_s[:, None, None] + phase
    sine, cosine = np.sin(angle), np.cos(angle)
    return (
        (amplitude * sine).sum(axis=2),
        (amplitude * omega * cosine).sum(axis=2),
        -(amplitude * omega**2 * sine).sum(axis=2),
    )
